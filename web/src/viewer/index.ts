import { ToileViewer } from "./element";

if (!customElements.get("toile-viewer")) customElements.define("toile-viewer", ToileViewer);

declare global {
  interface HTMLElementTagNameMap {
    "toile-viewer": ToileViewer;
  }
}

export { ToileViewer };
export type { DrapeDetail, ViewerEventMap, ViewerStats } from "./events";
