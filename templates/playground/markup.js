// Markup that symdyn wrote, of which only what is known here is shown, bit by bit.

const SLICE = 8; // ms that the page may be busy in one go
const LONG = 600; // elements of a formula that are laid out in one go

const TAGS = new Set(`math mrow mi mn mo ms mtext mspace msup msub msubsup mover munder munderover mfrac msqrt mroot mtable
  mtr mtd mstyle mpadded mphantom menclose div span p wbr br table thead tbody tr th td caption b i em strong code sub sup
  details summary ul ol li`.split(/\s+/));
const ATTRIBUTES = new Set(`class stretchy fence accent minsize maxsize width height depth lspace rspace mathvariant
  displaystyle scriptlevel linethickness columnalign rowalign open alttext colspan rowspan`.split(/\s+/));

/** Take from markup what is not known here; return what is left. */
function cleaned(node) {
  const root = node.ownerDocument.createDocumentFragment(); // still where nothing runs and nothing is loaded
  root.append(node);
  for (const element of root.querySelectorAll("*")) {
    if (!TAGS.has(element.localName)) { element.replaceWith(element.textContent); continue; }
    for (const { name } of [...element.attributes]) if (!ATTRIBUTES.has(name)) element.removeAttribute(name);
  }
  return document.importNode(root, true);
}

export const later = () => new Promise(done => setTimeout(done));
const pictured = () => (document.hidden ? later() : new Promise(done => requestAnimationFrame(() => setTimeout(done))));
const many = node => node.querySelectorAll?.("*").length ?? 0;

/** Show markup a block after another, and of long ones a part, so that a hand that types is never kept waiting. */
export async function fill(place, html, isWanted) {
  if (place.shown === html) return;
  place.shown = null;
  const { body } = new DOMParser().parseFromString(html, "text/html"); // where nothing runs and nothing is loaded
  const long = body.querySelector(":scope > .long"), fresh = document.createElement("div");
  const blocks = [...(long ?? body).childNodes].map(node => [fresh, node, false]);
  fresh.className = "symdyn-shown";
  place.replaceChildren(fresh);
  for (let begun = performance.now(), size = 0; blocks.length;) {
    const [into, node, isPart] = blocks.shift();
    if (many(node) > LONG && node.matches("div, span.term")) {
      const parts = [...node.childNodes];
      node.replaceChildren();
      const whole = into.appendChild(cleaned(node).firstChild);
      blocks.unshift(...parts.map(part => [whole, part, true]));
      continue;
    }
    size += isPart ? many(node) : 0;
    into.append(cleaned(node));
    if (performance.now() - begun < SLICE && size < LONG) continue;
    await (size < LONG ? later() : pictured());
    if (!isWanted()) return;
    begun = performance.now(), size = 0;
  }
  place.shown = html;
}
