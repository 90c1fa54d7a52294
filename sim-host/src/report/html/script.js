// Comforts only: tables that sort, tips at once. The page is complete without it.
"use strict";
function key(cell) {
  if (cell.dataset.v !== undefined) return Number(cell.dataset.v);
  const text = cell.textContent.trim();
  const number = Number(text.replace("★", "").replace("−", "-"));
  return text === "–" ? Infinity : Number.isNaN(number) ? text : number;
}
function order(a, b) {
  if (typeof a === typeof b) return a === b ? 0 : a > b ? 1 : -1;
  return typeof a === "number" ? -1 : 1;
}
document.querySelectorAll("table.sortable thead th").forEach(function (head) {
  const button = document.createElement("button");
  button.type = "button";
  button.append(...head.childNodes);
  head.append(button);
  button.addEventListener("click", function () {
    const up = head.getAttribute("aria-sort") !== "ascending";
    head.parentNode.querySelectorAll("th").forEach(function (other) { other.removeAttribute("aria-sort"); });
    head.setAttribute("aria-sort", up ? "ascending" : "descending");
    Array.from(head.closest("table").tBodies).forEach(function (body) {
      const rows = Array.from(body.rows);
      rows.sort(function (a, b) { return (up ? 1 : -1) * order(key(a.cells[head.cellIndex]), key(b.cells[head.cellIndex])); });
      body.append(...rows);
    });
  });
});
const tip = document.createElement("div");
tip.id = "tip";
tip.hidden = true;
document.body.append(tip);
document.querySelectorAll("svg.plot title").forEach(function (title) {
  const mark = title.parentNode;
  mark.dataset.tip = title.textContent;
  mark.setAttribute("aria-label", title.textContent);
  title.remove();
});
document.addEventListener("mousemove", function (event) {
  const mark = event.target.closest ? event.target.closest("[data-tip]") : null;
  tip.hidden = mark === null;
  if (mark === null) return;
  tip.textContent = mark.dataset.tip;
  tip.style.left = Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 8) + "px";
  tip.style.top = Math.min(event.clientY + 14, innerHeight - tip.offsetHeight - 8) + "px";
});
