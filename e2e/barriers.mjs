// What of a page shuts people out who do not see it or use no mouse: the serious and critical faults that axe-core finds.
import { readFileSync } from "node:fs";

const axe = readFileSync(new URL("node_modules/axe-core/axe.min.js", import.meta.url), "utf8");

/// A sentence for each rule that `page` breaks, with the first element that does; what is folded is unfolded.
export async function barriers(page) {
  await page.evaluate(axe);
  return page.evaluate(async () => {
    for (const folded of document.querySelectorAll("details")) folded.open = true;
    const { violations } = await globalThis.axe.run(document);
    const serious = violations.filter(({ impact }) => impact === "serious" || impact === "critical");
    return serious.map(({ id, help, nodes }) => `${id}: ${help}: ${nodes.length} times, first ${nodes[0].html.slice(0, 160)}`);
  });
}
