/** Validates the GLBs named on the command line; prints a line for every error or warning and fails if there is one. */
import { readFile } from "node:fs/promises";
import { argv, exit } from "node:process";
import validator from "gltf-validator";

const WARNING = 1;
let findings = 0;

for (const path of argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(path)), {
    maxIssues: 20,
    externalResourceFunction: () => Promise.reject(new Error("a GLB must be self-contained")),
  });
  for (const issue of report.issues.messages.filter(({ severity }) => severity <= WARNING)) {
    console.error(`${path}: ${issue.code} at ${issue.pointer}: ${issue.message}`);
    findings += 1;
  }
}

exit(findings === 0 ? 0 : 1);
