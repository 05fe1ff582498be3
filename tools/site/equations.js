// Typesets every equation of the page. One that KaTeX does not understand stays visible in red, with the reason under the pointer.
for (const place of document.querySelectorAll(".equation")) {
  katex.render(place.textContent, place, { displayMode: place.tagName === "DIV", throwOnError: false, strict: "error", output: "htmlAndMathml" });
}
