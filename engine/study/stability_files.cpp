// A StabilityMap as JSON and as a page that needs nothing else.
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/output/partial_file.h"
#include "engine/study/stability_map.h"

namespace lithe {
namespace {

constexpr const char* kPage = R"html(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Stability map</title>
<style>
:root { color-scheme: light dark; --ink: #222; --paper: #fff; --line: #ccc }
@media (prefers-color-scheme: dark) { :root { --ink: #ddd; --paper: #181818; --line: #444 } }
body { font: 14px/1.4 sans-serif; color: var(--ink); background: var(--paper); margin: 1rem; padding-bottom: 12rem }
h1 { font-size: 1.2rem; margin: 0 0 .5rem }
.wide { overflow-x: auto }
table { border-collapse: collapse }
th { font-weight: normal; text-align: left; white-space: nowrap; padding: 0 .6rem 0 0 }
thead th { vertical-align: bottom; padding: 0 0 .3rem }
thead th span { writing-mode: vertical-rl; transform: rotate(180deg) }
td { padding: 1px; white-space: nowrap }
td.others { padding-left: 1rem }
button { width: 1.05rem; height: 1.05rem; padding: 0; border: 1px solid var(--paper); border-radius: 2px; cursor: pointer;
  vertical-align: middle; line-height: 1 }
button:hover, button:focus-visible, button.chosen { outline: 2px solid var(--ink) }
.converged { background: #009e73 } .inaccurate { background: #e69f00 }
.unstable { background: #d55e00 } .refused { background: #8a8a8a }
.unstable::after { content: "\00d7"; color: #fff } .inaccurate::after { content: "\223c"; color: #000 }
.refused::after { content: "\2013"; color: #fff }
#key span { display: inline-block; margin-right: 1.2rem }
#key i { display: inline-block; width: 1rem; height: 1rem; border-radius: 2px; margin-right: .3rem; vertical-align: -2px;
  font-style: normal; text-align: center; line-height: 1rem }
#words { position: fixed; left: 0; right: 0; bottom: 0; max-height: 11rem; overflow-y: auto; padding: .6rem 1rem;
  background: var(--paper); border-top: 1px solid var(--line) }
#words p { margin: .1rem 0 }
</style></head><body>
<h1>Stability map: scenes and methods</h1>
<p id="key"></p>
<div class="wide"><table><thead></thead><tbody></tbody></table></div>
<div id="words" role="status" aria-live="polite">Choose a square by a click, or by Tab and the arrow keys.</div>
<script type="application/json" id="cells">@CELLS@</script>
<script>
"use strict";
const cells = JSON.parse(document.getElementById("cells").textContent);
const outcomes = {
  converged: "the detector is within its limit", inaccurate: "it ends, but outside the limit",
  unstable: "it grows without bound, or its step collapses", refused: "it stops and says why"};
const made = (name, text, parent) => {
  const element = document.createElement(name);
  if (text) element.textContent = text;
  return parent.appendChild(element);
};
const key = document.getElementById("key");
for (const [outcome, meaning] of Object.entries(outcomes)) {
  const entry = made("span", "", key);
  made("i", "", entry).className = outcome;
  entry.append(`${outcome}: ${meaning}`);
}
const columns = [...new Set(cells.map(c => c.column).filter(c => c))];
const scenes = new Map();
for (const cell of cells) scenes.set(cell.scene, [...(scenes.get(cell.scene) ?? []), cell]);

const head = made("tr", "", document.querySelector("thead"));
made("th", "", head);
for (const column of columns) made("span", column, made("th", "", head));
const has_others = cells.some(c => !c.column);
if (has_others) made("span", "the scene's own", made("th", "", head));

const words = document.getElementById("words");
const short = value => String(Number(value.toPrecision(3)));
let chosen = null;
function choose(button, cell) {
  chosen?.classList.remove("chosen");
  chosen = button;
  button.classList.add("chosen");
  words.textContent = "";
  made("strong", `${cell.scene} ${cell.title} — ${cell.method}: ${cell.outcome}`, made("p", "", words));
  if (cell.value !== null) made("p", `${cell.measure}: ${short(cell.value)}`, words);
  if (cell.more) made("p", cell.more, words);
  if (cell.largest_stable_step_s !== null) made("p", `largest stable step: ${short(cell.largest_stable_step_s)} s`, words);
  if (cell.why) made("p", cell.why, words);
  if (cell.expected) made("p", `published: ${cell.expected}`, words);
}
function square(cell, parent) {
  const button = made("button", "", parent);
  button.className = cell.outcome;
  button.title = `${cell.method}: ${cell.outcome}`;
  button.setAttribute("aria-label", `${cell.scene}, ${cell.method}: ${cell.outcome}`);
  button.onclick = button.onfocus = () => choose(button, cell);
}
for (const [scene, list] of scenes) {
  const row = made("tr", "", document.querySelector("tbody"));
  made("th", `${scene} ${list[0].title}`, row);
  for (const column of columns) {
    const field = made("td", "", row);
    for (const cell of list.filter(c => c.column === column)) square(cell, field);
  }
  if (!has_others) continue;
  const others = made("td", "", row);
  others.className = "others";
  for (const cell of list.filter(c => !c.column)) square(cell, others);
}
document.querySelector("tbody").addEventListener("keydown", event => {
  const step = {ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowDown: [1, 0], ArrowUp: [-1, 0]}[event.key];
  const row = event.target.closest("tr");
  if (!step || event.target.tagName !== "BUTTON") return;
  event.preventDefault();
  const rows = [...row.parentElement.children], at = [...row.querySelectorAll("button")].indexOf(event.target);
  const to = [...(rows[rows.indexOf(row) + step[0]]?.querySelectorAll("button") ?? [])];
  to[Math.min(at + step[1], to.length - (step[0] ? 1 : 0))]?.focus();
});
</script></body></html>
)html";

nlohmann::json number_or_null(double value) { return std::isfinite(value) ? nlohmann::json(value) : nullptr; }

nlohmann::json as_json(const std::vector<StabilityCell>& cells) {
  nlohmann::json out = nlohmann::json::array();
  for (const StabilityCell& cell : cells)
    out.push_back({{"scene", cell.scene},
                   {"title", cell.title},
                   {"method", cell.method},
                   {"column", cell.column},
                   {"outcome", to_string(cell.outcome)},
                   {"measure", cell.measure},
                   {"value", number_or_null(cell.value)},
                   {"largest_stable_step_s", number_or_null(cell.largest_stable_step)},
                   {"why", cell.why},
                   {"more", cell.more},
                   {"expected", cell.expected}});
  return out;
}

void write_text(const std::string& path, const std::string& text) {
  PartialFile file(path);
  file.stream() << text;
  file.commit();
}

}  // namespace

void StabilityMap::write_json(const std::string& path) const {
  write_text(path, nlohmann::json{{"cells", as_json(cells_)}}.dump(1) + "\n");
}

void StabilityMap::write_page(const std::string& path) const {
  std::string data = as_json(cells_).dump();
  // "</script>" in a user's words would end the data.
  for (std::size_t at = 0; (at = data.find("</", at)) != std::string::npos; at += 3) data.replace(at, 2, "<\\/");
  std::string page = kPage;
  const std::string place = "@CELLS@";
  write_text(path, page.replace(page.find(place), place.size(), data));
}

}  // namespace lithe
