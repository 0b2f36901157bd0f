// Help of the server for the text: completion, hover, definition, uses, rename, layout. It speaks the Language Server Protocol.
import { acceptCompletion, autocompletion, completionKeymap, selectedCompletionIndex } from "@codemirror/autocomplete";
import type { CompletionContext, CompletionResult } from "@codemirror/autocomplete";
import {
  LSPClient,
  Workspace,
  findReferencesKeymap,
  formatKeymap,
  hoverTooltips,
  jumpToDefinition,
  jumpToDefinitionKeymap,
  renameKeymap,
  serverCompletionSource,
} from "@codemirror/lsp-client";
import type { WorkspaceFile } from "@codemirror/lsp-client";
import { ChangeSet, Text } from "@codemirror/state";
import type { Extension, TransactionSpec } from "@codemirror/state";
import { EditorView, keymap } from "@codemirror/view";
import { isPanel } from "../studio/panel.js";

/** The parts of the page that the help needs. */
export interface Page {
  /** The texts of the model, by file. */
  files(): Record<string, string>;
  edit(file: string, text: string): void;
  /** Puts a file into the editor. */
  show(file: string): EditorView;
  /** Sends a message of the protocol; gives the messages that come back. */
  send(message: string): Promise<string[]>;
}

interface HelpedFile extends WorkspaceFile {
  view: EditorView | null;
}

/** All texts of the model are open at the server; one of them is in the editor. The URI of a file is its name. */
class ModelFiles extends Workspace {
  files: HelpedFile[] = [];

  constructor(
    client: LSPClient,
    private readonly page: Page,
  ) {
    super(client);
  }

  private texts(): Array<[string, string]> {
    return Object.entries(this.page.files()).filter(([name, text]) => !name.endsWith(".md") && !isPanel(text));
  }

  private add(name: string, text: string): void {
    const file: HelpedFile = { uri: name, languageId: "espalier", version: 0, doc: Text.of(text.split("\n")), view: null, getView: () => file.view };
    this.files.push(file);
    this.client.didOpen(file);
  }

  syncFiles() {
    const texts = new Map(this.texts());
    for (const { uri } of this.files.filter((file) => !texts.has(file.uri))) {
      this.client.didClose(uri);
    }
    this.files = this.files.filter(({ uri }) => texts.has(uri));
    const updates = [];
    for (const [name, text] of texts) {
      const file = this.getFile(name) as HelpedFile | null;
      if (!file) {
        this.add(name, text);
        continue;
      }
      const doc = file.view?.state.doc ?? Text.of(text.split("\n"));
      if (!doc.eq(file.doc)) {
        updates.push({ file, prevDoc: file.doc, changes: ChangeSet.of({ from: 0, to: file.doc.length, insert: doc }, file.doc.length) });
        file.doc = doc;
        ++file.version;
      }
    }
    return updates;
  }

  override connected(): void {
    const views = new Map(this.files.map(({ uri, view }) => [uri, view]));
    this.files = [];
    this.texts().forEach(([name, text]) => this.add(name, text));
    this.files.forEach((file) => (file.view = views.get(file.uri) ?? null));
  }

  openFile(uri: string, _language: string, view: EditorView): void {
    this.client.sync();
    const file = this.getFile(uri) as HelpedFile | null;
    if (file) {
      file.view = view;
    }
  }

  closeFile(uri: string): void {
    const file = this.getFile(uri) as HelpedFile | null;
    if (file) {
      file.view = null;
    }
  }

  override updateFile(uri: string, update: TransactionSpec): void {
    const file = this.getFile(uri) as HelpedFile | null;
    if (file?.view) {
      file.view.dispatch(update);
    } else if (file) {
      this.page.edit(uri, ChangeSet.of(update.changes ?? [], file.doc.length).apply(file.doc).toString());
    }
  }

  override displayFile(uri: string): Promise<EditorView | null> {
    return Promise.resolve(this.getFile(uri) ? this.page.show(uri) : null);
  }
}

const HARMLESS = new Set(["P", "PRE", "CODE", "EM", "STRONG", "UL", "OL", "LI", "TABLE", "THEAD", "TBODY", "TR", "TH", "TD", "BR", "SPAN", "H1", "H2", "H3", "BLOCKQUOTE"]);

/** The text of a model may come from a link of a stranger: only plain elements stay. */
function withoutHarm(html: string): string {
  const { body } = new DOMParser().parseFromString(html, "text/html");
  for (const element of [...body.querySelectorAll("*")]) {
    if (HARMLESS.has(element.tagName)) {
      [...element.attributes].filter(({ name }) => name !== "class").forEach(({ name }) => element.removeAttribute(name));
    } else {
      element.replaceWith(element.textContent ?? "");
    }
  }
  return body.innerHTML;
}

/** The text of the server about a line of a file. */
export interface Lens {
  line: number; // from 0
  title: string;
}

/** Words that fit, without the one that is being written. */
async function others(context: CompletionContext): Promise<CompletionResult | null> {
  const result = await serverCompletionSource(context);
  const before = context.matchBefore(/\w+/)?.text ?? "";
  const after = /^\w*/.exec(context.state.doc.lineAt(context.pos).text.slice(context.pos - context.state.doc.lineAt(context.pos).from))![0];
  const written = before + after; // the caret may stand inside the word
  return result && { ...result, options: result.options.filter(({ label }) => label !== written) };
}

export class LanguageHelp {
  private readonly client: LSPClient;
  private handlers: Array<(message: string) => void> = [];
  private sending: Promise<unknown> = Promise.resolve();

  constructor(private readonly page: Page) {
    this.client = new LSPClient({
      timeout: 20_000,
      sanitizeHTML: withoutHarm,
      workspace: (client) => new ModelFiles(client, page),
      // the page shows the problems that `model.check` finds: it knows also the files that are no texts
      notificationHandlers: { "textDocument/publishDiagnostics": () => true },
    });
  }

  /** Begins a conversation: on a new connection, a new one. */
  connect(): void {
    if (this.client.connected) {
      this.client.disconnect();
    }
    this.client.connect({
      send: (message) => {
        // the next message goes after the answer to the last
        this.sending = this.sending
          .then(() => this.page.send(message))
          .then((answers) => answers.forEach((answer) => this.handlers.forEach((handle) => handle(answer))))
          .catch(() => {});
      },
      subscribe: (handler) => (this.handlers = [...this.handlers, handler]),
      unsubscribe: (handler) => (this.handlers = this.handlers.filter((one) => one !== handler)),
    });
  }

  /** The extension for the editor of a file. */
  extension(file: string): Extension {
    return [
      this.client.plugin(file, "espalier"),
      hoverTooltips({ hoverTime: 400 }),
      autocompletion({
        // names of modules have one letter: a list for each would be in the way
        override: [(context) => (context.explicit || context.matchBefore(/\w{2,}/) ? others(context) : null)],
        defaultKeymap: false,
        interactionDelay: 0,
      }),
      EditorView.domEventHandlers({
        mousedown: (event, view) => {
          const at = event.ctrlKey || event.metaKey ? view.posAtCoords({ x: event.clientX, y: event.clientY }) : null;
          if (at === null) {
            return false;
          }
          view.dispatch({ selection: { anchor: at } });
          return jumpToDefinition(view);
        },
      }),
    ];
  }

  /** How often the run has applied the productions of a file. */
  async lenses(file: string): Promise<Lens[]> {
    if (!this.client.connected) {
      return [];
    }
    await this.client.initializing;
    this.client.sync();
    const found = await this.client.request<object, Array<{ range: { start: { line: number } }; command: { title: string } }>>("textDocument/codeLens", { textDocument: { uri: file } });
    return found.map(({ range, command }) => ({ line: range.start.line, title: command.title }));
  }

  /** Keys of the help; they come before the editor's own. */
  readonly keys: Extension = keymap.of([
    // Enter is a new line, unless a person has gone down the list
    { key: "Enter", run: (view) => (selectedCompletionIndex(view.state) ?? 0) > 0 && acceptCompletion(view) },
    { key: "Tab", run: acceptCompletion },
    ...completionKeymap.filter(({ key }) => key !== "Enter"),
    ...renameKeymap,
    ...jumpToDefinitionKeymap,
    ...findReferencesKeymap,
    ...formatKeymap,
  ]);
}
