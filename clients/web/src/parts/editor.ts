// The text editor: CodeMirror with the colours of the language and marks at problems.
import { closeBrackets, closeBracketsKeymap } from "@codemirror/autocomplete";
import { defaultKeymap, history, historyKeymap, indentWithTab, redo, undo } from "@codemirror/commands";
import { HighlightStyle, StreamLanguage, bracketMatching, indentOnInput, syntaxHighlighting } from "@codemirror/language";
import type { StringStream } from "@codemirror/language";
import { lintGutter, lintKeymap, setDiagnostics } from "@codemirror/lint";
import type { Diagnostic as Mark } from "@codemirror/lint";
import { highlightSelectionMatches, searchKeymap } from "@codemirror/search";
import { Annotation, EditorState, StateEffect, StateField } from "@codemirror/state";
import { Decoration, EditorView, WidgetType, drawSelection, highlightActiveLine, highlightActiveLineGutter, keymap, lineNumbers } from "@codemirror/view";
import type { DecorationSet } from "@codemirror/view";
import { tags } from "@lezer/highlight";
import type { Diagnostic } from "espalier";
import type { LanguageHelp, Lens } from "./language_help.js";

const STATEMENTS =
  /^(?:Lsystem|derivation length|Axiom|axiom|consider|ignore|seed|homomorphism|interpretation|decomposition|maximum depth|production|Module|Start|End|StartEach|EndEach|endlsystem|[a-z][a-z ]+)(?=\s*:)|^(?:homomorphism|decomposition|endlsystem)\b/;
const WORDS = /^(?:if|else|while|for|do|return|stop|printf|warnOnEmpty|nosuccessor|include)\b/;

interface Scanner {
  isComment: boolean;
}

const language = StreamLanguage.define<Scanner>({
  startState: () => ({ isComment: false }),
  token(stream: StringStream, state: Scanner) {
    if (state.isComment || stream.match("/*")) {
      state.isComment = !stream.match(/^.*?\*\//);
      if (state.isComment) {
        stream.skipToEnd();
      }
      return "comment";
    }
    if (stream.match(/^\/\/.*/)) {
      return "comment";
    }
    if (stream.sol() && stream.match(/^\s*#\s*\w+/)) {
      return "meta";
    }
    if (stream.sol() && stream.match(STATEMENTS)) {
      return "keyword";
    }
    if (stream.match(/^-->|^->|^→/)) {
      return "definition";
    }
    if (stream.match(/^(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?/)) {
      return "number";
    }
    if (stream.match(/^"(?:[^"\\]|\\.)*"/)) {
      return "string";
    }
    if (stream.match(WORDS)) {
      return "keyword";
    }
    if (stream.match(/^[\[\]{}]/)) {
      return "bracket";
    }
    if (stream.match(/^\?[A-Z]\w*/)) {
      return "special";
    }
    if (stream.match(/^[A-Za-z_]\w*/)) {
      return "name";
    }
    if (stream.match(/^[-+&^\\/|!;,@~%$*<>:=]/)) {
      return "operator";
    }
    stream.next();
    return null;
  },
  tokenTable: { definition: tags.definitionKeyword, bracket: tags.squareBracket, special: tags.special(tags.variableName), name: tags.variableName },
  languageData: { commentTokens: { block: { open: "/*", close: "*/" } } },
});

const colours = HighlightStyle.define([
  { tag: tags.comment, color: "var(--code-comment)", fontStyle: "italic" },
  { tag: tags.meta, color: "var(--code-macro)" },
  { tag: tags.keyword, color: "var(--code-keyword)", fontWeight: "600" },
  { tag: tags.definitionKeyword, color: "var(--code-arrow)", fontWeight: "600" },
  { tag: tags.number, color: "var(--code-number)" },
  { tag: tags.string, color: "var(--code-string)" },
  { tag: tags.squareBracket, color: "var(--code-bracket)", fontWeight: "600" },
  { tag: tags.special(tags.variableName), color: "var(--code-query)", fontWeight: "600" },
  { tag: tags.variableName, color: "var(--text)" },
  { tag: tags.operator, color: "var(--code-operator)" },
]);

const theme = EditorView.theme({
  "&": { height: "100%", fontSize: "13px", backgroundColor: "var(--panel)", color: "var(--text)" },
  ".cm-scroller": { fontFamily: "var(--mono)", lineHeight: "1.55" },
  ".cm-gutters": { backgroundColor: "var(--panel)", color: "var(--quiet)", border: "none", paddingLeft: "2px" },
  ".cm-activeLine": { backgroundColor: "var(--line)" },
  ".cm-activeLineGutter": { backgroundColor: "transparent", color: "var(--text)" },
  ".cm-cursor": { borderLeftColor: "var(--text)" },
  "&.cm-focused": { outline: "none" },
  "&.cm-focused .cm-selectionBackground, .cm-selectionBackground": { backgroundColor: "var(--selection) !important" },
  ".cm-tooltip": { backgroundColor: "var(--raised)", border: "1px solid var(--edge)", borderRadius: "6px", color: "var(--text)" },
  ".cm-diagnostic": { fontFamily: "var(--mono)", fontSize: "12px", padding: "6px 10px" },
  ".cm-lens": { color: "var(--quiet)", fontSize: "11px", paddingLeft: "1.5em", whiteSpace: "nowrap" },
  ".cm-lens-never": { fontStyle: "italic" },
  ".cm-panels": { backgroundColor: "var(--raised)", color: "var(--text)" },
});

// a change that the page makes, not the person
const fromPage = Annotation.define<boolean>();

/** Behind a production: how often the run has applied it. */
class LensText extends WidgetType {
  constructor(private readonly title: string) {
    super();
  }

  override eq(other: LensText): boolean {
    return other.title === this.title;
  }

  toDOM(): HTMLElement {
    const text = document.createElement("span");
    text.className = this.title.startsWith("never") ? "cm-lens cm-lens-never" : "cm-lens";
    text.textContent = this.title;
    return text;
  }
}

const setLenses = StateEffect.define<DecorationSet>();

const lensField = StateField.define<DecorationSet>({
  create: () => Decoration.none,
  update: (shown, transaction) => transaction.effects.reduce((last, effect) => (effect.is(setLenses) ? effect.value : last), shown.map(transaction.changes)),
  provide: (field) => EditorView.decorations.from(field),
});

const encoder = new TextEncoder();
const decoder = new TextDecoder();

/** The place in the text of a line and a column that counts bytes, both from 1. */
export function placeOf(state: EditorState, line: number, column: number): number {
  const found = state.doc.line(Math.min(Math.max(line, 1), state.doc.lines));
  const before = decoder.decode(encoder.encode(found.text).subarray(0, column - 1));
  return found.from + Math.min(before.length, found.length);
}

/** The name that a hint offers instead of the marked one. */
export const remedyOf = (hint: string | undefined): string | null => /did you mean '([^']+)'\?/i.exec(hint ?? "")?.[1] ?? null;

export class Editor {
  private readonly view: EditorView;
  private readonly states = new Map<string, EditorState>();
  private file = "";
  private current = ""; // document and file
  private marks: Diagnostic[] = [];

  constructor(
    parent: HTMLElement,
    private readonly onEdit: (file: string, text: string) => void,
    private readonly onBuild: () => void,
    private readonly help: LanguageHelp | null, // null: the text is only read
  ) {
    this.view = new EditorView({ parent, state: this.made("", "") });
    // long lines are scrolled with the keyboard too
    this.view.scrollDOM.tabIndex = 0;
  }

  private made(file: string, text: string): EditorState {
    return EditorState.create({
      doc: text,
      extensions: [
        lineNumbers(),
        highlightActiveLine(),
        highlightActiveLineGutter(),
        drawSelection(),
        EditorView.lineWrapping,
        history(),
        bracketMatching(),
        closeBrackets(),
        indentOnInput(),
        highlightSelectionMatches(),
        lintGutter(),
        lensField,
        language,
        syntaxHighlighting(colours),
        theme,
        EditorView.contentAttributes.of({ "aria-label": "Text of the model" }),
        EditorState.tabSize.of(4),
        file && this.help ? [this.help.keys, this.help.extension(file)] : [],
        EditorState.readOnly.of(this.help === null),
        keymap.of([
          { key: "Mod-Enter", run: () => (this.onBuild(), true) },
          ...closeBracketsKeymap,
          ...defaultKeymap,
          ...searchKeymap,
          ...historyKeymap,
          ...lintKeymap,
          indentWithTab,
        ]),
        EditorView.updateListener.of((update) => {
          if (update.docChanged && !update.transactions.some((one) => one.annotation(fromPage))) {
            this.onEdit(this.file, update.state.doc.toString());
          }
        }),
      ],
    });
  }

  /** Shows a file. A text that differs from the shown one changes only in the part that differs, so that undo goes on. */
  show(document: string, file: string, text: string): EditorView {
    const key = `${document}\n${file}`;
    if (this.current !== key) {
      this.states.set(this.current, this.view.state);
      this.file = file;
      this.current = key;
      const known = this.states.get(key);
      this.view.setState(known ?? this.made(file, text));
      this.mark(this.marks);
    }
    const shown = this.view.state.doc.toString();
    if (shown === text) {
      return this.view;
    }
    let begin = 0;
    while (begin < Math.min(shown.length, text.length) && shown[begin] === text[begin]) {
      ++begin;
    }
    let end = 0;
    while (end < Math.min(shown.length, text.length) - begin && shown[shown.length - 1 - end] === text[text.length - 1 - end]) {
      ++end;
    }
    this.view.dispatch({
      changes: { from: begin, to: shown.length - end, insert: text.slice(begin, text.length - end) },
      annotations: fromPage.of(true),
    });
    return this.view;
  }

  /** Marks the problems of the shown file. */
  mark(diagnostics: Diagnostic[]): void {
    this.marks = diagnostics;
    const { state } = this.view;
    const marks = diagnostics
      .filter(({ file, range }) => range && (file ?? "").split("/").pop() === this.file)
      .map(({ range, message, hint, severity }): Mark => {
        const begin = placeOf(state, range!.begin.line, range!.begin.column);
        const line = state.doc.lineAt(begin);
        // behind the end of a line there is nothing to underline: its last character stands for it
        const from = begin === line.to && begin > line.from ? begin - 1 : begin;
        const to = Math.max(placeOf(state, range!.end.line, range!.end.column), Math.min(from + 1, state.doc.length));
        const remedy = remedyOf(hint);
        return {
          from,
          to,
          severity: severity === "note" ? "info" : severity,
          message: hint ? `${message}\n${hint}` : message,
          ...(remedy && { actions: [{ name: `Change to '${remedy}'`, apply: (view: EditorView, at: number, end: number) => view.dispatch({ changes: { from: at, to: end, insert: remedy } }) }] }),
        };
      });
    this.view.dispatch(setDiagnostics(state, marks));
  }

  /** Shows what the server says about lines of a file, unless the editor shows another one by now. */
  showLenses(file: string, lenses: Lens[]): void {
    if (file !== this.file) {
      return;
    }
    const { doc } = this.view.state;
    const titles = new Map<number, string>();
    for (const { line, title } of lenses.filter(({ line }) => line < doc.lines)) {
      titles.set(line, [titles.get(line), title].filter(Boolean).join(" · "));
    }
    const marks = [...titles].map(([line, title]) => Decoration.widget({ widget: new LensText(title), side: 1 }).range(doc.line(line + 1).to));
    this.view.dispatch({ effects: setLenses.of(Decoration.set(marks, true)) });
  }

  goTo(line: number, column: number): void {
    const at = placeOf(this.view.state, line, column);
    this.view.dispatch({ selection: { anchor: at }, effects: EditorView.scrollIntoView(at, { y: "center" }) });
    this.view.focus();
  }

  /** Writes a text instead of the place from a line and column to another. */
  replace(begin: { line: number; column: number }, end: { line: number; column: number }, text: string): void {
    const { state } = this.view;
    this.view.dispatch({ changes: { from: placeOf(state, begin.line, begin.column), to: placeOf(state, end.line, end.column), insert: text } });
    this.view.focus();
  }

  undo(isRedo: boolean): void {
    (isRedo ? redo : undo)(this.view);
  }

  focus(): void {
    this.view.focus();
  }
}
