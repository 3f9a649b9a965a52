// A search in the texts of all pages: sections.js holds them and is loaded when somebody begins to type.
const root = document.currentScript.dataset.root;
var sections; // set by sections.js

const field = Object.assign(document.createElement("input"), { type: "search", placeholder: "Search" });
field.setAttribute("aria-label", "Search in all pages");
const found = document.createElement("ul");
found.setAttribute("aria-live", "polite");
document.querySelector("header").append(field, found);

/** Sections that have all words: those with more of them in the heading first, then in the order of the pages. */
function matches(words) {
  const hits = [];
  for (const [address, page, heading, text] of sections) {
    const title = (page + " " + heading).toLowerCase();
    const all = title + " " + text.toLowerCase();
    if (words.every((word) => all.includes(word)))
      hits.push({ address, page, heading, inTitle: words.filter((word) => title.includes(word)).length });
  }
  return hits.sort((a, b) => b.inTitle - a.inTitle);
}

function show() {
  const words = field.value.toLowerCase().split(/\s+/).filter(Boolean);
  found.replaceChildren();
  if (!words.length || !sections) return;
  const hits = matches(words);
  for (const hit of hits.slice(0, 15)) {
    const link = Object.assign(document.createElement("a"), { href: root + "/" + hit.address });
    link.textContent = hit.heading === hit.page ? hit.page : hit.page + ": " + hit.heading;
    found.append(document.createElement("li"));
    found.lastChild.append(link);
  }
  if (!hits.length) found.append(Object.assign(document.createElement("li"), { textContent: "nothing found" }));
}

field.addEventListener("focus", () => {
  const script = Object.assign(document.createElement("script"), { src: root + "/sections.js", onload: show });
  document.head.append(script);
}, { once: true });
field.addEventListener("input", show);
