// Errors of this page, kept in it, where a test reads them: <script id="faults">, a JSON list.

const place = document.getElementById("faults");

function keep(text) {
  place.textContent = JSON.stringify([...JSON.parse(place.textContent), String(text)]);
}

addEventListener("error", (event) => keep(event.message));
addEventListener("unhandledrejection", (event) => keep(event.reason));
for (const level of ["error", "warn"]) {
  const said = console[level];
  console[level] = (...words) => {
    keep(words.join(" "));
    said.apply(console, words);
  };
}
