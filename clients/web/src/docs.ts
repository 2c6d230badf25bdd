// The API's own documentation, from openapi.json alone: nothing is fetched from elsewhere.

import "./docs.css";
import { byId } from "./dom";

interface Schema {
  $ref?: string;
  anyOf?: Schema[];
  oneOf?: Schema[];
  allOf?: Schema[];
  enum?: unknown[];
  const?: unknown;
  type?: string;
  format?: string;
  items?: Schema;
  description?: string;
  properties?: Record<string, Schema>;
  required?: string[];
}

interface Content {
  [media: string]: { schema?: Schema };
}

interface Operation {
  summary?: string;
  description?: string;
  parameters?: {
    name: string;
    in: string;
    required?: boolean;
    schema?: Schema;
    description?: string;
  }[];
  requestBody?: { content?: Content };
  responses: Record<string, { description?: string; content?: Content }>;
}

interface Document {
  info: { description?: string };
  paths: Record<string, Record<string, Operation>>;
  components: { schemas: Record<string, Schema> };
}

type Row = [name: string, type: Node, told: string | undefined];

function element(name: string, text: string, ...children: (string | Node)[]): HTMLElement {
  const made = document.createElement(name);
  if (text) made.textContent = text;
  made.append(...children);
  return made;
}

/** "PoseSnapshot", "list of number or null": a schema in a few words, with links to the types. */
function typeOf(schema: Schema | undefined): Node {
  if (!schema) return element("span", "anything");
  if (schema.$ref) {
    const name = schema.$ref.split("/").at(-1) ?? "";
    const link = element("a", name);
    link.setAttribute("href", `#${name}`);
    return link;
  }
  const choices = schema.anyOf ?? schema.oneOf ?? schema.allOf;
  if (choices) {
    const parts = choices.flatMap((choice, place) =>
      place ? [" or ", typeOf(choice)] : [typeOf(choice)],
    );
    return element("span", "", ...parts);
  }
  if (schema.enum) return element("span", schema.enum.join(" | "));
  if (schema.const !== undefined) return element("span", String(schema.const));
  if (schema.type === "array") return element("span", "", "list of ", typeOf(schema.items));
  return element("span", schema.format ?? schema.type ?? "anything");
}

function table(rows: Row[]): HTMLElement {
  const body = element("tbody", "");
  for (const [name, type, told] of rows) {
    const line = element("tr", "", element("td", "", element("code", name)));
    line.append(element("td", "", type), element("td", told ?? ""));
    body.append(line);
  }
  return element("table", "", body);
}

function operation(path: string, method: string, told: Operation): HTMLElement {
  const code = element("code", `${method.toUpperCase()} ${path}`);
  const box = element("details", "", element("summary", "", code, ` ${told.summary ?? ""}`));
  box.append(element("p", told.description ?? ""));
  const asked: Row[] = (told.parameters ?? []).map((one) => [
    `${one.name}${one.required ? "" : "?"}`,
    element("span", `${one.in}: `, typeOf(one.schema)),
    one.description ?? one.schema?.description,
  ]);
  for (const [media, body] of Object.entries(told.requestBody?.content ?? {})) {
    asked.push(["body", typeOf(body.schema), media]);
  }
  if (asked.length) box.append(table(asked));
  const answers = Object.entries(told.responses).map(([status, answer]): Row => {
    const [content] = Object.values(answer.content ?? {});
    return [status, content ? typeOf(content.schema) : element("span", ""), answer.description];
  });
  box.append(table(answers));
  return box;
}

function type(name: string, schema: Schema): HTMLElement {
  const box = element("details", "", element("summary", "", element("code", name)));
  box.id = name;
  box.append(element("p", schema.description ?? schema.enum?.join(" | ") ?? ""));
  const required = new Set(schema.required ?? []);
  const fields = Object.entries(schema.properties ?? {});
  box.append(
    table(
      fields.map(([field, one]) => [
        required.has(field) ? field : `${field}?`,
        typeOf(one),
        one.description,
      ]),
    ),
  );
  return box;
}

/** A link to a type opens it. */
function open(): void {
  const box = document.getElementById(location.hash.slice(1));
  if (box instanceof HTMLDetailsElement) box.open = true;
}

const told = (await (await fetch("openapi.json")).json()) as Document;
for (const [path, operations] of Object.entries(told.paths)) {
  for (const [method, one] of Object.entries(operations)) {
    byId("operations").append(operation(path, method, one));
  }
}
for (const [name, schema] of Object.entries(told.components.schemas)) {
  byId("types").append(type(name, schema));
}
byId("about").prepend(`${told.info.description ?? ""} `);
addEventListener("hashchange", open);
open();
