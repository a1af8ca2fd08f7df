// A button below each figure that saves the drawing that is shown as an SVG file; without scripts a report has no button.
for (const figure of document.querySelectorAll("figure")) {
  const shown = () => [...figure.querySelectorAll("svg")].find((svg) => svg.getClientRects().length > 0);
  if (!figure.querySelector("svg")) continue;
  const button = document.createElement("button");
  button.type = "button";
  button.className = "save";
  button.textContent = "Save as SVG";
  button.addEventListener("click", () => {
    const svg = (shown() ?? figure.querySelector("svg")).cloneNode(true);
    const { width, height } = svg.viewBox.baseVal;
    svg.removeAttribute("class");
    svg.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    svg.setAttribute("width", "900");
    svg.setAttribute("height", `${Math.round((900 * height) / width)}`);
    const caption = figure.querySelector("figcaption")?.textContent;
    if (caption) {
      const description = document.createElementNS("http://www.w3.org/2000/svg", "desc");
      description.textContent = caption;
      svg.prepend(description);
    }
    const number = [...document.querySelectorAll("figure")].indexOf(figure) + 1;
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([svg.outerHTML], { type: "image/svg+xml" }));
    link.download = `figure-${number}.svg`;
    link.click();
    URL.revokeObjectURL(link.href);
  });
  figure.append(button);
}
