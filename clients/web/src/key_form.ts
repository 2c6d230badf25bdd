// Changes a key for a session where the server needs one; the cookie is out of every page's reach.

import { beginSession, ProblemError } from "./api";
import { byId, setText } from "./dom";

/** @param entered told when a session has begun. */
export function keyForm(base: URL, entered: () => void): void {
  const field = byId<HTMLInputElement>("key");
  const problem = byId("key-problem");
  byId<HTMLFormElement>("key-form").addEventListener("submit", async (event) => {
    event.preventDefault();
    setText(problem, "");
    try {
      await beginSession(base, field.value.trim());
      field.value = "";
      entered();
    } catch (error) {
      const told = error instanceof ProblemError ? error.message : "The server does not answer.";
      setText(problem, told);
    }
  });
}
