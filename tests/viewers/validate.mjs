// Prints what Khronos' validator finds in .glb files: node validate.mjs PACKAGES FILE...
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
const [packages, ...files] = process.argv.slice(2);
const validator = createRequire(packages + "/x.js")("gltf-validator");
const found = {};
for (const file of files) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)));
  found[file] = { issues: report.issues, info: report.info };
}
console.log(JSON.stringify(found));
