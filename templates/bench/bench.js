"use strict";
(() => {
  const find = (id) => document.getElementById(id);
  const script = find("script"), verdict = find("verdict"), report = find("report"), button = find("verify");
  const rows = document.querySelector("#numbers tbody");
  const asFiled = find("filed").value;
  // "shank_d = 12;" or "shank_d = as_designed ? 12 : 12.003;", as scripts begin; what it is stands in a comment on the
  // line before or behind it.
  const named = /^([A-Za-z_]\w*)( *= *(?:as_designed *\? *)?)(-?[0-9.]+(?:e-?[0-9]+)?)((?: *:[^;]*)?;(?: *\/\/ *(.*))?.*)$/;
  const remark = /^\/\/ *(.*)$/;

  function showNumbers() {
    rows.replaceChildren();
    script.value.split("\n").forEach((line, index, all) => {
      const found = named.exec(line), before = index > 0 && remark.exec(all[index - 1]);
      if (!found) return;
      const row = rows.insertRow(), name = document.createElement("th"), input = document.createElement("input");
      name.scope = "row";
      name.textContent = found[1];
      input.value = found[3];
      input.name = found[1];
      input.inputMode = "decimal";
      input.setAttribute("aria-label", found[1]);
      input.addEventListener("input", () => {
        const lines = script.value.split("\n"), now = named.exec(lines[index]);
        if (!now || !Number.isFinite(Number.parseFloat(input.value))) return;
        lines[index] = now[1] + now[2] + input.value.trim() + now[4];
        script.value = lines.join("\n");
      });
      row.append(name);
      row.insertCell().append(input);
      row.insertCell().textContent = before ? before[1] : found[5] || "";
    });
    find("numbers").hidden = rows.rows.length === 0;
  }

  function say(text, kind) {
    verdict.textContent = text;
    verdict.className = kind;
  }

  let runs = 0;
  async function verify() {
    if (button.disabled) return;
    button.disabled = true;
    say("Verifying ...", "");
    try {
      const answer = await fetch("verify", { method: "POST", body: script.value, headers: { "Content-Type": "text/plain" } });
      const said = await answer.json();
      if (answer.ok) {
        say(said.sentence, said.outcome);
        report.src = "report?" + ++runs + "#map";
      } else {
        say(said.error, "error");
      }
    } catch (failure) {
      say("The program does not answer: was it ended?", "error");
    }
    button.disabled = false;
    document.body.dataset.runs = String(runs);
  }

  find("bench").addEventListener("submit", (event) => { event.preventDefault(); verify(); });
  document.addEventListener("keydown", (event) => {
    if (event.key === "Enter" && (event.ctrlKey || event.metaKey)) { event.preventDefault(); verify(); }
  });
  find("undo").addEventListener("click", () => { script.value = asFiled; showNumbers(); });
  find("download").addEventListener("click", (event) => {
    event.currentTarget.href = URL.createObjectURL(new Blob([script.value], { type: "text/plain" }));
  });
  script.addEventListener("input", showNumbers);
  showNumbers();
})();
