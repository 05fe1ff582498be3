// Typesets every equation of the page. One that KaTeX does not understand stays as it is written, in red, with the reason under the
// pointer: KaTeX's own error handling would colour a single unknown command and hide it from tests.
for (const place of document.querySelectorAll(".equation")) {
  const source = place.textContent;
  try {
    katex.render(source, place, { displayMode: place.tagName === "DIV", strict: "error", output: "htmlAndMathml" });
  } catch (error) {
    place.textContent = source;
    place.classList.add("katex-error");
    place.title = error.message;
  }
}
