// The entry: which server, which station.

import "./page.css";
import { Page } from "./page";

new Page(new URL(".", location.href), new URLSearchParams(location.search).get("station"));
