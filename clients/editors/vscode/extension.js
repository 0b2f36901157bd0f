// Starts `espalier language-server` and connects it with the editor.
const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = () => {
  const command = workspace.getConfiguration("espalier").get("program");
  client = new LanguageClient("espalier", "Espalier", { command, args: ["language-server"] },
    { documentSelector: [{ language: "espalier" }] });
  return client.start();
};

exports.deactivate = () => client && client.stop();
