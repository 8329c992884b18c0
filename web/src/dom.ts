// A few words for making elements.
type Child = Node | string | null | undefined | false;

export function el<K extends keyof HTMLElementTagNameMap>(tag: K, properties: Partial<HTMLElementTagNameMap[K]> & { class?: string; data?: Record<string, string> } = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const out = document.createElement(tag);
  const { class: name, data, ...rest } = properties;
  if (name) out.className = name;
  if (data) Object.assign(out.dataset, data);
  Object.assign(out, rest);
  for (const c of children) if (c) out.append(c);
  return out;
}

export const $ = <T extends HTMLElement = HTMLElement>(id: string): T => document.getElementById(id) as T;

export function button(text: string, title: string, action: () => void, name = ""): HTMLButtonElement {
  return el("button", { type: "button", textContent: text, title, class: name, onclick: action });
}

// 17 digits name every double; 9 are easier to read.
export function digits(value: number | null | undefined, full: boolean): string {
  if (value === null || value === undefined) return "–";
  return full ? String(value) : String(Number(value.toPrecision(9)));
}
