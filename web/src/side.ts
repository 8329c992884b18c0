// The panel beside the plot: its tabs, and the divider that gives it its width.
import { $ } from "./dom";

const buttons = () => document.querySelectorAll<HTMLElement>("#side nav button");

export function markTab(tab: string): void {
  for (const b of buttons()) {
    b.setAttribute("aria-selected", String(b.dataset.tab === tab));
    b.tabIndex = b.dataset.tab === tab ? 0 : -1;
  }
}

// Clicks and arrow keys go from tab to tab.
export function installTabs<T extends string>(tabs: T[], present: () => T, show: (tab: T) => void): void {
  for (const b of buttons()) {
    b.onclick = () => show(b.dataset.tab as T);
    b.onkeydown = (e) => {
      const by = e.key === "ArrowRight" ? 1 : e.key === "ArrowLeft" ? -1 : 0;
      if (!by) return;
      e.preventDefault();
      e.stopPropagation();
      const next = tabs[(tabs.indexOf(present()) + by + tabs.length) % tabs.length];
      show(next);
      document.querySelector<HTMLElement>(`[data-tab=${next}]`)!.focus();
    };
  }
}

function setWidth(width: number): void {
  $("side").style.width = `${width}px`;
  $("divider").setAttribute("aria-valuenow", String(Math.round((100 * $("side").clientWidth) / innerWidth)));
}

export function installDivider(): void {
  const divider = $("divider");
  divider.onpointerdown = (e) => {
    divider.setPointerCapture(e.pointerId);
    divider.onpointermove = (m) => setWidth(innerWidth - m.clientX - 3);
    divider.onpointerup = () => (divider.onpointermove = null);
  };
  divider.onkeydown = (e) => {
    const by = e.key === "ArrowLeft" ? 24 : e.key === "ArrowRight" ? -24 : 0;
    if (!by) return;
    setWidth($("side").clientWidth + by);
    e.preventDefault();
    e.stopPropagation();
  };
}
