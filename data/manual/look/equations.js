// Sets the equations. Without it they stay readable as TeX.
for (const element of document.querySelectorAll(".equation")) {
  katex.render(element.textContent, element, {displayMode: element.tagName === "DIV", throwOnError: false});
}
