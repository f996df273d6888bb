// SPDX-License-Identifier: MIT
// Debian's furo knows "dark" and "light", and leaves "auto" light: here it becomes what the system prefers.
(() => {
  const prefersDark = window.matchMedia("(prefers-color-scheme: dark)");
  const resolve = () => {
    const theme = document.body.dataset.theme;
    const chosen = localStorage.getItem("theme") || "auto";
    const wanted = chosen === "auto" ? (prefersDark.matches ? "dark" : "light") : chosen;
    if (theme !== wanted) document.body.dataset.theme = wanted;
  };
  document.addEventListener("DOMContentLoaded", () => {
    resolve();
    new MutationObserver(resolve).observe(document.body, { attributes: true, attributeFilter: ["data-theme"] });
    prefersDark.addEventListener("change", resolve);
  });
})();
