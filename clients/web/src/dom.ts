// The few things that every view does with the document.

/** The element of this id, which index.html has. */
export function byId<Kind extends Element = HTMLElement>(id: string): Kind {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no #${id}`);
  return found as unknown as Kind;
}

/** A new element with a class, and text or children in it. */
export function element<Name extends keyof HTMLElementTagNameMap>(
  name: Name,
  className = "",
  ...children: (string | Node)[]
): HTMLElementTagNameMap[Name] {
  const made = document.createElement(name);
  if (className) made.className = className;
  made.append(...children);
  return made;
}

/** Change a text only where it is another one: screen readers tell of every change. */
export function setText(node: Node, text: string): void {
  if (node.textContent !== text) node.textContent = text;
}

/** "180 ms", "12 s", "3 min" */
export function duration(us: number): string {
  if (us < 1e6) return `${Math.max(us / 1e3, 0).toFixed(0)} ms`;
  if (us < 120e6) return `${(us / 1e6).toFixed(0)} s`;
  return `${(us / 60e6).toFixed(0)} min`;
}

export function percent(share: number): string {
  return `${Math.round(share * 100)} %`;
}

export function cssColor(rgb: number[]): string {
  return `rgb(${rgb.join(" ")})`;
}
