// Light or dark: as the system says until someone chooses.

const root = document.documentElement;
const system = matchMedia("(prefers-color-scheme: dark)");
const listeners = [];

function isDark() {
  return root.style.colorScheme === "" ? system.matches : root.style.colorScheme === "dark";
}

function tell() {
  listeners.forEach((listener) => listener(isDark()));
}

system.addEventListener("change", tell);

/** Chooses one. */
export function setTheme(name) {
  root.style.colorScheme = name;
  tell();
}

/** Chooses the other one. */
export function toggleTheme() {
  setTheme(isDark() ? "light" : "dark");
}

/** Calls `listener(dark)` now and at every change. */
export function onTheme(listener) {
  listeners.push(listener);
  listener(isDark());
}
