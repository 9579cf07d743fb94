// A question in the page. confirm() would stop the page, and Stop with it, until it is answered.
import { element, make } from './dom';

// A new one takes the place of the last.
export function ask(words: string, yes: string, act: () => void): void {
  const place = element('question');
  const answer = (text: string, testid: string, then: () => void): HTMLButtonElement => {
    const button = make('button', { type: 'button', textContent: text }, { testid });
    button.addEventListener('click', () => {
      forget_question();
      then();
    });
    return button;
  };
  const no = answer('Cancel', 'question-no', () => {});
  place.replaceChildren(make('p', { textContent: words }), no, answer(yes, 'question-yes', act));
  place.hidden = false;
  no.focus({ preventScroll: true });
}

export function forget_question(): void {
  element('question').hidden = true;
}
