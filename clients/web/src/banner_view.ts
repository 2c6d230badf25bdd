// Banners in the document: one element a kind, told to screen readers when it comes.

import type { Banner } from "./banners";
import { element, setText } from "./dom";

const SIGNS = { bad: "!", unsure: "?", info: "i" } as const;

export class BannerView {
  private readonly shown = new Map<string, HTMLElement>();

  /** @param place an empty element that stays in the document. */
  constructor(private readonly place: HTMLElement) {}

  show(banners: Banner[]): void {
    for (const [id, node] of this.shown) {
      if (banners.some((banner) => banner.id === id)) continue;
      node.remove();
      this.shown.delete(id);
    }
    for (const banner of banners) {
      const node = this.shown.get(banner.id) ?? this.add(banner);
      fill(node, banner);
    }
  }

  private add(banner: Banner): HTMLElement {
    const sign = element("span", "sign", SIGNS[banner.level]);
    sign.setAttribute("aria-hidden", "true");
    const bar = element("progress");
    bar.setAttribute("aria-label", "Progress");
    const node = element("div", "banner", sign, element("p", "", element("strong"), " "), bar);
    node.dataset.banner = banner.id;
    node.setAttribute("role", banner.level === "info" ? "status" : "alert");
    node.querySelector("p")?.append(element("span"));
    this.shown.set(banner.id, node);
    this.place.append(node);
    return node;
  }
}

function fill(node: HTMLElement, banner: Banner): void {
  node.dataset.level = banner.level;
  const [title, text] = [node.querySelector("strong"), node.querySelector("p span")];
  if (title) setText(title, banner.title);
  if (text) setText(text, banner.text);
  const bar = node.querySelector("progress");
  if (bar) {
    bar.hidden = banner.progress === null;
    bar.value = banner.progress ?? 0;
  }
}
