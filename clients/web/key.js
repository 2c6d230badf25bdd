// Changes a key for a session, where the server needs one; the cookie is out of every page's reach.

const form = document.getElementById("key-form");
const field = document.getElementById("key");
const problem = document.getElementById("key-problem");

form.addEventListener("submit", async (event) => {
  event.preventDefault();
  problem.textContent = "";
  try {
    const answer = await fetch("v1/session", {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify({ key: field.value.trim() }),
    });
    if (!answer.ok) {
      problem.textContent = (await answer.json()).detail;
      return;
    }
    field.value = "";
    form.hidden = true;
  } catch {
    problem.textContent = "The server does not answer.";
  }
});
