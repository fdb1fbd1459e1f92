import "../styles/tokens.css";
import "../styles/layout.css";
import "../styles/stage.css";
import "../styles/compare.css";
import "../styles/controls.css";
import "../styles/panels.css";
import "../viewer/index";
import { FittingRoom } from "./fitting_room";

const viewer = document.querySelector("toile-viewer");
const stage = document.querySelector<HTMLElement>(".stage");
const panel = document.querySelector<HTMLElement>("#panel");

if (viewer && stage && panel) void new FittingRoom(viewer, stage, panel).open();
