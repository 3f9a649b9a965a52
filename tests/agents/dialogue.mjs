// dialogue.mjs PARTSCRIBE SCAN-FOLDER: an agent's dialogue with `partscribe mcp`, by the protocol's own client. A bundled
// scan is built; a hole of the script is made wrong, found, mended and verified. Prints what was said.
import { Client } from "@modelcontextprotocol/sdk/client/index.js";
import { StdioClientTransport } from "@modelcontextprotocol/sdk/client/stdio.js";
import assert from "node:assert/strict";
import { cpSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const [program, scanFolder] = process.argv.slice(2);
const root = mkdtempSync(join(tmpdir(), "partscribe-agent-"));
cpSync(scanFolder, join(root, "scan"), { recursive: true });
const client = new Client({ name: "dialogue", version: "1" });
const transport = new StdioClientTransport({ command: program, args: ["mcp", "--root", root] });

const text = (result) => result.content.filter((c) => c.type === "text").map((c) => c.text).join("\n");
const pictures = (result) => result.content.filter((c) => c.type === "image").map((c) => Buffer.from(c.data, "base64"));
const isPng = (bytes) => bytes.subarray(1, 4).toString() === "PNG";

async function call(name, args, options = {}) {
  console.log(`\n> ${name} ${JSON.stringify(args)}\n`);
  const result = await client.callTool({ name, arguments: args }, undefined, { timeout: 300000, ...options });
  console.log(text(result));
  for (const picture of pictures(result)) {
    assert(isPng(picture));
    console.log(`[a picture, ${picture.length} bytes]`);
  }
  return result;
}

try {
  await client.connect(transport);
  assert.equal(client.getServerVersion().name, "partscribe");
  const { tools } = await client.listTools();
  console.log("Tools: " + tools.map((t) => t.name).join(", "));
  assert.deepEqual(tools.map((t) => t.name), ["build", "verify", "explain", "measure", "render"]);
  const verifyTool = tools.find((t) => t.name === "verify");
  assert.deepEqual(verifyTool.inputSchema.required, ["files"]);
  assert.equal(verifyTool.inputSchema.properties.tolerance.type, "number");
  assert.deepEqual(verifyTool.inputSchema.properties.align.enum, ["none", "best-fit", "datums"]);

  const steps = [];
  const built = await call("build", { scan: ["scan/scan.json"], name: "tie bar", tolerance: 0.1, to: ["openscad"] },
    { onprogress: (p) => steps.push(p) });
  assert(!built.isError && built.structuredContent.verdict === "verified");
  assert(steps.length >= 4 && steps.every((p, i) => i === 0 || p.progress >= steps[i - 1].progress));
  console.log("\nProgress: " + [...new Set(steps.map((p) => p.message.replace(/ \d+ %$/, "")))].join(", "));
  assert(pictures(built).length >= 1);

  const file = built.structuredContent.files.find((f) => f.endsWith(".scad"));
  const right = readFileSync(join(root, file), "utf8");
  const hole = built.structuredContent.parameters.find((p) => /hole|bore/.test(p.name) && p.quantity === "length");
  const wrong = right.replace(new RegExp(`^${hole.name} = [0-9.]+;`, "m"), `${hole.name} = ${hole.value + 2};`);
  assert.notEqual(wrong, right);
  console.log(`\n(The agent writes ${hole.name} = ${hole.value + 2} in place of ${hole.value}.)`);
  writeFileSync(join(root, file), wrong);
  const judged = await call("verify", { files: [file, "scan/scan.json"], tolerance: 0.1 });
  assert(!judged.isError && judged.structuredContent.verdict === "out_of_tolerance");
  assert.equal(judged.structuredContent.exit_code, 1);
  const [task] = judged.structuredContent.tasks;
  console.log("\nFirst task: " + JSON.stringify(task, null, 1));
  const diameter = task.dimensions.find((d) => d.name === "diameter");
  assert(Math.abs(diameter.artifact_says - diameter.scan_measures - 2) < 0.1);
  assert(pictures(judged).length === 2);

  console.log(`\n(The agent mends it: ${hole.name} = ${hole.value}.)`);
  writeFileSync(join(root, file), right);
  const again = await call("verify", { files: [file, "scan/scan.json"], tolerance: 0.1 });
  assert.equal(again.structuredContent.verdict, "verified");
  assert.deepEqual(again.structuredContent.tasks, []);

  const folder = file.slice(0, file.lastIndexOf("/"));
  const explained = await call("explain", { model: folder });
  assert(explained.structuredContent.parameters.some((p) => p.name === hole.name));
  const drawn = await call("render", { files: [file], view: "top" });
  assert.equal(pictures(drawn).length, 1);

  const outside = await call("verify", { files: ["../../etc/passwd", "scan/scan.json"] });
  assert(outside.isError && /within/.test(text(outside)));
  const nothing = await call("verify", { files: ["no.scad", "scan/scan.json"] });
  assert(nothing.isError && /no such file/.test(text(nothing)));

  const stop = new AbortController();
  const begin = Date.now();
  const running = client.callTool({ name: "build", arguments: { scan: ["scan/scan.json"], out: "again" } }, undefined,
    { signal: stop.signal, onprogress: () => stop.abort("enough") });
  await assert.rejects(running);
  await client.ping();
  console.log(`\n(A build was cancelled after ${((Date.now() - begin) / 1000).toFixed(1)} s; the server answers.)`);
  console.log("\n1 passed, 0 failed");
} finally {
  await client.close();
  rmSync(root, { recursive: true, force: true });
}
