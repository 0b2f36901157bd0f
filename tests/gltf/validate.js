// Validates .glb files with the Khronos validator: node validate.js FILE...
// Prints what it finds in a file, and one line at the end: `N passed, N failed`. A file fails with any error or warning.
import { readFile } from 'node:fs/promises'
import { basename } from 'node:path'
import validator from 'gltf-validator'

const SEVERITIES = ['error', 'warning']

async function isValid(file) {
  const report = await validator.validateBytes(new Uint8Array(await readFile(file)), {
    uri: basename(file),
    maxIssues: 1000,
  })
  const { numErrors, numWarnings, messages } = report.issues
  for (const { severity, code, message, pointer } of messages) {
    if (severity > 1) continue
    console.log(`${file}: ${SEVERITIES[severity]} ${code} at ${pointer ?? 'the file'}: ${message}`)
  }
  return numErrors === 0 && numWarnings === 0
}

let passed = 0
let failed = 0
for (const file of process.argv.slice(2)) {
  let valid = false
  try {
    valid = await isValid(file)
  } catch (problem) {
    console.log(`${file}: ${problem}`)
  }
  if (valid) passed += 1
  else failed += 1
}
console.log(`${passed} passed, ${failed} failed`)
process.exitCode = failed === 0 && passed > 0 ? 0 : 1
