// The question which text is to stay, when the file of the scene was changed by somebody else.
import { make } from '../dom';
import { button } from './controls';

export class Conflict {
  readonly place = make('div', { className: 'notice', hidden: true }, { testid: 'editor-conflict' });

  constructor() {
    this.place.setAttribute('role', 'alert');
  }

  ask(why: string, load: () => void, replace: () => void): void {
    const then = (act: () => void) => () => {
      this.hide();
      act();
    };
    const theirs = button('Load the file', 'editor-theirs', then(load));
    const mine = button('Keep mine, replace the file', 'editor-mine', then(replace));
    this.place.replaceChildren(make('p', { textContent: why }), theirs, mine);
    this.place.hidden = false;
  }
  hide(): void {
    this.place.hidden = true;
  }
}
