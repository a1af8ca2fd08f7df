// What is measured in a page; runs in the browser. Every fault is a sentence.

/// All faults of the page that is shown.
export function faults() {
  const found = new Set();
  const shortened = (text) => {
    const line = text.replace(/\s+/g, " ").trim();
    return line.length > 60 ? `${line.slice(0, 59)}…` : line;
  };
  const named = (element) => {
    const card = element.closest("section, figure");
    const heading = card?.closest("section")?.querySelector("h2")?.textContent ?? document.title;
    const name = element.tagName.toLowerCase() + (element.classList.length ? `.${[...element.classList].join(".")}` : "");
    return `${name} in "${shortened(heading)}"`;
  };
  const isShown = (element) => element.getClientRects().length > 0;
  const px = (value) => `${value.toFixed(1)} px`;
  const root = document.documentElement;

  if (root.scrollWidth > root.clientWidth + 1) {
    found.add(`the page scrolls sideways: ${root.scrollWidth} of ${root.clientWidth} px`);
  }

  // Elements stand within their card; what scrolls within it is asked at its frame.
  const scrolls = (element) => ["auto", "scroll"].includes(getComputedStyle(element).overflowX);
  for (const card of document.querySelectorAll("section")) {
    const style = getComputedStyle(card);
    const frame = card.getBoundingClientRect();
    const [left, right] = [frame.left + parseFloat(style.paddingLeft), frame.right - parseFloat(style.paddingRight)];
    const visit = (element) => {
      if (!isShown(element)) return;
      const box = element.getBoundingClientRect();
      if (box.right > right + 1 || box.left < left - 1) {
        found.add(`${named(element)} leaves its card by ${px(Math.max(box.right - right, left - box.left))}: ${shortened(element.textContent)}`);
        return;
      }
      if (element instanceof SVGElement || scrolls(element)) return;
      for (const child of element.children) visit(child);
    };
    for (const child of card.children) visit(child);
  }
  // Texts stand within the element that holds them.
  for (const element of document.querySelectorAll("main *:not(svg, svg *)")) {
    if (!isShown(element) || scrolls(element) || element.clientWidth === 0) continue;
    if (element.scrollWidth > element.clientWidth + 1) {
      found.add(`${named(element)} is ${element.scrollWidth - element.clientWidth} px too narrow for: ${shortened(element.textContent)}`);
    }
  }

  // Figures: every text inside the drawing, large enough, and clear of the others.
  const drawings = new Map();
  for (const svg of document.querySelectorAll("svg")) {
    if (!isShown(svg)) continue;
    const frame = svg.getBoundingClientRect();
    const texts = [...svg.querySelectorAll("text")].filter((text) => text.textContent.trim());
    if (texts.length === 0) found.add(`${named(svg)}: a figure without a text`);
    const small = [];
    const boxes = texts.map((text) => {
      const matrix = text.getScreenCTM();
      const scale = Math.sqrt(Math.abs(matrix.a * matrix.d - matrix.b * matrix.c));
      const size = parseFloat(getComputedStyle(text).fontSize) * scale;
      if (size < 11 - 0.05) small.push(size);
      const box = text.getBoundingClientRect();
      // The letters are lower than the line that they stand on.
      const upright = Math.abs(matrix.b) > Math.abs(matrix.a);
      const [x, y] = upright ? [0.15 * box.width, 0] : [0, 0.15 * box.height];
      const [left, right, top, bottom] = [box.left + x, box.right - x, box.top + y, box.bottom - y];
      if (left < frame.left || right > frame.right || top < frame.top || bottom > frame.bottom) {
        found.add(`${named(svg)}: a text leaves the figure: ${shortened(text.textContent)}`);
      }
      return { text: text.textContent, left, right, top, bottom };
    });
    if (small.length > 0) found.add(`${named(svg)}: ${small.length} texts of ${px(Math.min(...small))} and more`);
    boxes.forEach((a, i) => {
      for (const b of boxes.slice(i + 1)) {
        const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
        const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        if (across > 0.5 && down > 0.5) found.add(`${named(svg)}: texts overlap: "${shortened(a.text)}" and "${shortened(b.text)}"`);
      }
    });
    const drawn = svg.innerHTML;
    if (drawings.has(drawn)) found.add(`${named(svg)}: the figure of ${drawings.get(drawn)} again`);
    drawings.set(drawn, named(svg));
  }

  // Texts of the page.
  for (const element of document.querySelectorAll("main *:not(svg, svg *)")) {
    if (isShown(element) && element.children.length === 0 && element.textContent.trim()) {
      const size = parseFloat(getComputedStyle(element).fontSize);
      if (size < 11) found.add(`${named(element)}: text of ${px(size)}: ${shortened(element.textContent)}`);
    }
  }
  const wrong = [
    [/(?:^|[\s(])[−-]0(?:\.0+)?(?=$|[\s,;)%°])/, "a zero with a sign"],
    [/± 0(?:\.0+)?(?=$|[\s,;)%°])/, "a spread of zero"],
    [/NaN|Infinity|(?:^|\s)inf(?:$|\s)|undefined/, "no number"],
  ];
  for (const element of document.querySelectorAll("td, th, li, p, b, figcaption, text, summary")) {
    if (!isShown(element)) continue;
    for (const [pattern, what] of wrong) {
      if (pattern.test(element.textContent)) found.add(`${named(element)}: ${what}: ${shortened(element.textContent)}`);
    }
  }
  return [...found];
}
