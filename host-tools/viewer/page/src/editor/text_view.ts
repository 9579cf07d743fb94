// The text of the scene, with its errors in line. Undo and redo of all that the editor does are the history of this text.
import {
  defaultKeymap,
  history,
  historyKeymap,
  indentWithTab,
  isolateHistory,
  redo,
  redoDepth,
  undo,
  undoDepth,
} from '@codemirror/commands';
import { HighlightStyle, StreamLanguage, bracketMatching, indentOnInput, indentUnit, syntaxHighlighting } from '@codemirror/language';
import { json } from '@codemirror/legacy-modes/mode/javascript';
import { type Diagnostic, lintGutter, lintKeymap, setDiagnostics } from '@codemirror/lint';
import { Annotation, EditorState, type Extension } from '@codemirror/state';
import {
  EditorView,
  drawSelection,
  highlightActiveLine,
  highlightActiveLineGutter,
  highlightSpecialChars,
  keymap,
  lineNumbers,
} from '@codemirror/view';
import { tags } from '@lezer/highlight';

import type { Issue } from '../protocol';
import type { Edit } from './json_edits';

const kFromElsewhere = Annotation.define<boolean>();

const kColors = HighlightStyle.define([
  { tag: [tags.string, tags.special(tags.string)], color: 'var(--code-string)' },
  { tag: [tags.number, tags.bool, tags.null, tags.atom], color: 'var(--code-number)' },
  { tag: [tags.propertyName, tags.special(tags.propertyName)], color: 'var(--code-key)' },
  { tag: tags.comment, color: 'var(--muted)', fontStyle: 'italic' },
]);

const kExtensions: Extension = [
  lineNumbers(),
  highlightSpecialChars(),
  history(),
  drawSelection(),
  indentOnInput(),
  indentUnit.of('  '),
  bracketMatching(),
  highlightActiveLine(),
  highlightActiveLineGutter(),
  StreamLanguage.define({ ...json, tokenTable: { property: tags.propertyName } }),
  syntaxHighlighting(kColors),
  lintGutter(),
  // Esc, then Tab leaves the text, as CodeMirror has it; Esc stops the arm too.
  keymap.of([...defaultKeymap, ...historyKeymap, ...lintKeymap, indentWithTab]),
  EditorView.scrollHandler.of((view, { head }) => !view.hasFocus && scroll_alone(view, head)),
  EditorView.contentAttributes.of({ 'aria-label': 'Text of the scene', tabindex: '0' }),
];

export class TextView {
  private readonly view: EditorView;

  constructor(
    place: HTMLElement,
    private readonly listener: { changed(): void; at(offset: number): void },
  ) {
    this.view = new EditorView({ parent: place, state: this.state('') });
  }

  get text(): string {
    return this.view.state.sliceDoc();
  }
  get can_undo(): boolean {
    return undoDepth(this.view.state) > 0;
  }
  get can_redo(): boolean {
    return redoDepth(this.view.state) > 0;
  }
  get is_focused(): boolean {
    return this.view.hasFocus;
  }

  // Another scene: nothing of this can be undone.
  begin(text: string): void {
    this.view.setState(this.state(text));
  }

  // One step of the history. A text that came from elsewhere is not told to the listener.
  edit(edits: readonly Edit[], from_elsewhere = false): void {
    if (edits.length === 0) return;
    const at = (offset: number) => this.position(offset);
    this.view.dispatch({
      changes: edits.map(({ offset, length, content }) => ({ from: at(offset), to: at(offset + length), insert: content })),
      annotations: [isolateHistory.of('full'), kFromElsewhere.of(from_elsewhere)],
      userEvent: 'input.editor',
    });
  }
  undo(): void {
    undo(this.view);
  }
  redo(): void {
    redo(this.view);
  }

  show_issues(issues: readonly Issue[]): void {
    const { doc } = this.view.state;
    const found = issues.map((issue): Diagnostic => {
      const line = doc.line(Math.min(Math.max(issue.line, 1), doc.lines));
      const from = line.from + offset_of_column(line.text, issue.column);
      return { from, to: end_of_value(line.text, line.from, from), severity: 'error', message: `${issue.cause}\n${issue.remedy}` };
    });
    this.view.dispatch(setDiagnostics(this.view.state, found));
  }

  reveal(offset: number): void {
    const anchor = this.position(offset);
    this.view.dispatch({ selection: { anchor }, effects: EditorView.scrollIntoView(anchor, { y: 'center' }) });
  }
  reveal_line(line: number, column: number): void {
    const { doc } = this.view.state;
    const at = doc.line(Math.min(Math.max(line, 1), doc.lines));
    const anchor = at.from + offset_of_column(at.text, column);
    this.view.focus();
    this.view.dispatch({ selection: { anchor }, effects: EditorView.scrollIntoView(anchor, { y: 'center' }) });
  }
  destroy(): void {
    this.view.destroy();
  }

  // A document of CodeMirror counts the end of a line as one, also where it has two characters.
  private position(offset: number): number {
    const { state } = this.view;
    if (state.lineBreak.length === 1) return Math.min(offset, state.doc.length);
    return Math.min(offset - (state.sliceDoc().slice(0, offset).split(state.lineBreak).length - 1), state.doc.length);
  }

  private state(text: string): EditorState {
    const ends = EditorState.lineSeparator.of(text.includes('\r\n') ? '\r\n' : '\n');
    const told = EditorView.updateListener.of((update) => {
      if (update.docChanged && !update.transactions.some((one) => one.annotation(kFromElsewhere))) this.listener.changed();
      else if (update.selectionSet && this.view.hasFocus)
        this.listener.at(this.view.state.sliceDoc(0, update.state.selection.main.head).length);
    });
    return EditorState.create({ doc: text, extensions: [ends, kExtensions, told] });
  }
}

// Without the page, so that the picture stays where it is when an object is selected there or in the list.
function scroll_alone(view: EditorView, at: number): true {
  const line = view.lineBlockAt(at);
  view.scrollDOM.scrollTop = line.top - (view.scrollDOM.clientHeight - line.height) / 2;
  return true;
}

// The compiler counts characters, from 1; a text of JavaScript has two units for some.
function offset_of_column(line: string, column: number): number {
  return [...line].slice(0, Math.max(column - 1, 0)).join('').length;
}

function end_of_value(line: string, line_from: number, from: number): number {
  const rest = line.slice(from - line_from);
  const length = /^("(\\.|[^"\\])*"|[^\s,\]}]+)/.exec(rest)?.[0].length ?? 0;
  return from + Math.max(length, Math.min(rest.length, 1));
}
