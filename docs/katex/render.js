// Renders what pymdownx.arithmatex marks; katex.min.js (KaTeX 0.19.1) is loaded before.
document.querySelectorAll(".arithmatex").forEach((element) => {
  const text = element.textContent.trim();
  const display = text.startsWith("\\[");
  katex.render(text.slice(2, -2), element, { displayMode: display, throwOnError: false });
});
