// The API's own documentation, from openapi.json alone: nothing is fetched from elsewhere.

const document_ = await (await fetch("openapi.json")).json();

function element(name, text, ...children) {
  const made = document.createElement(name);
  if (text) made.textContent = text;
  made.append(...children);
  return made;
}

// "PoseSnapshot", "list of number or null": a schema in a few words, with links to the types.
function typeOf(schema) {
  if (!schema) return element("span", "anything");
  if (schema.$ref) {
    const name = schema.$ref.split("/").at(-1);
    const link = element("a", name);
    link.href = `#${name}`;
    return link;
  }
  const choices = schema.anyOf ?? schema.oneOf ?? schema.allOf;
  if (choices) {
    const parts = choices.flatMap((choice, place) => (place ? [" or ", typeOf(choice)] : [typeOf(choice)]));
    return element("span", "", ...parts);
  }
  if (schema.enum) return element("span", schema.enum.join(" | "));
  if (schema.const !== undefined) return element("span", String(schema.const));
  if (schema.type === "array") return element("span", "", "list of ", typeOf(schema.items));
  return element("span", schema.format ?? schema.type ?? "anything");
}

function table(rows) {
  const body = element("tbody");
  for (const [name, type, told] of rows) {
    const line = element("tr", "", element("td", "", element("code", name)));
    line.append(element("td", "", type), element("td", told ?? ""));
    body.append(line);
  }
  return element("table", "", body);
}

function operation(path, method, told) {
  const box = element("details", "", element("summary", "", element("code", `${method.toUpperCase()} ${path}`)));
  box.firstChild.append(` ${told.summary ?? ""}`);
  box.append(element("p", told.description ?? ""));
  const asked = (told.parameters ?? []).map((one) => [
    `${one.name}${one.required ? "" : "?"}`,
    element("span", `${one.in}: `, typeOf(one.schema)),
    one.description ?? one.schema?.description,
  ]);
  for (const [media, body] of Object.entries(told.requestBody?.content ?? {})) {
    asked.push(["body", typeOf(body.schema), media]);
  }
  if (asked.length) box.append(table(asked));
  const answers = Object.entries(told.responses).map(([status, answer]) => {
    const [content] = Object.values(answer.content ?? {});
    return [status, content ? typeOf(content.schema) : element("span"), answer.description];
  });
  box.append(table(answers));
  return box;
}

for (const [path, operations] of Object.entries(document_.paths)) {
  for (const [method, told] of Object.entries(operations)) {
    document.getElementById("operations").append(operation(path, method, told));
  }
}
for (const [name, schema] of Object.entries(document_.components.schemas)) {
  const box = element("details", "", element("summary", "", element("code", name)));
  box.id = name;
  box.append(element("p", schema.description ?? schema.enum?.join(" | ") ?? ""));
  const required = new Set(schema.required ?? []);
  const fields = Object.entries(schema.properties ?? {});
  box.append(table(fields.map(([field, one]) => [required.has(field) ? field : `${field}?`, typeOf(one), one.description])));
  document.getElementById("types").append(box);
}
document.getElementById("about").prepend(`${document_.info.description ?? ""} `);

// A link to a type opens it.
function open() {
  const box = document.getElementById(location.hash.slice(1));
  if (box instanceof HTMLDetailsElement) box.open = true;
}
addEventListener("hashchange", open);
open();
