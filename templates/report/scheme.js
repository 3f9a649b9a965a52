// Light or dark: as the system says until the button is pressed. A choice holds for this page and is kept where the browser allows.
"use strict";
(() => {
  const button = document.getElementById("scheme"), root = document.documentElement, system = matchMedia("(prefers-color-scheme: dark)");
  const kept = "partscribe-scheme";
  const dark = () => root.dataset.scheme ? root.dataset.scheme === "dark" : system.matches;
  const show = () => {
    button.textContent = dark() ? "Light colours" : "Dark colours";
    root.dispatchEvent(new Event("schemechange"));
  };
  try {
    const scheme = localStorage.getItem(kept);
    if (scheme === "dark" || scheme === "light") root.dataset.scheme = scheme;
  } catch { /* pages on a disk may have no storage */ }
  button.hidden = false;
  button.addEventListener("click", () => {
    root.dataset.scheme = dark() ? "light" : "dark";
    try { localStorage.setItem(kept, root.dataset.scheme); } catch { /* as above */ }
    show();
  });
  system.addEventListener("change", show);
  show();
})();
