// The errors of the text, as a list; a press shows the place of one.
import { make } from '../dom';
import type { Issue } from '../protocol';

export class IssueList {
  readonly place = make('section', { className: 'issues' });
  private readonly list = make('ul', {}, { testid: 'editor-issues' });
  private shown = '';
  count = 0;

  constructor(private readonly reveal: (line: number, column: number) => void) {
    this.place.setAttribute('aria-label', 'Errors of the text');
    this.list.setAttribute('aria-live', 'polite');
    this.place.append(this.list);
  }

  show(issues: readonly Issue[], more: number): void {
    this.count = issues.length;
    const key = JSON.stringify([issues, more]);
    if (key === this.shown) return;
    this.shown = key;
    const items = issues.map((issue) => this.item(issue));
    if (more > 0) items.push(make('li', { textContent: `and ${more} more` }));
    this.list.replaceChildren(...items);
  }

  private item(issue: Issue): HTMLLIElement {
    const item = make('li');
    const link = make('button', { type: 'button', textContent: `Line ${issue.line}` });
    link.addEventListener('click', () => this.reveal(issue.line, issue.column));
    item.append(link, make('span', { textContent: ` ${issue.cause}: ${issue.remedy}` }));
    return item;
  }
}
