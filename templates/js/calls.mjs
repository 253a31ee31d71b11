// Reads the text of a module as one line of JSON, then calls, one a line, and answers each with one line. Doubles travel
// as hexadecimal bytes, so that every bit arrives, those of NaN too.
import { createInterface } from "node:readline";

const numbers = hex => {
  const bytes = Buffer.from(hex, "hex");
  return Float64Array.from({ length: bytes.length / 8 }, (_, i) => bytes.readDoubleLE(8 * i));
};
const hex = values => {
  const bytes = Buffer.alloc(8 * values.length);
  values.forEach((value, i) => bytes.writeDoubleLE(value, 8 * i));
  return bytes.toString("hex");
};
const answer = words => process.stdout.write(JSON.stringify(words) + "\n");

let module;
for await (const line of createInterface({ input: process.stdin })) {
  const words = JSON.parse(line);
  try {
    if (module === undefined) {
      module = await import("data:text/javascript;base64," + Buffer.from(words).toString("base64"));
      answer({ names: Object.keys(module) });
    } else {
      const given = words.arguments.map(({ scalar, bytes }) => (scalar ? numbers(bytes)[0] : numbers(bytes)));
      const result = module[words.name](...given);
      answer({ bytes: hex(typeof result === "number" ? [result] : result) });
    }
  } catch (fault) {
    answer({ fault: String(fault) });
  }
}
