// The gallery: a card for each scene, with its picture, one line and a mark where its task has been done.
import { element, make } from './dom';
import type { DoneTasks } from './tasks_done';
import { kTasks } from './tasks';
import type { SceneGallery } from './transport';

export class GalleryView {
  private readonly list = element('gallery-scenes');
  private readonly cards = new Map<string, HTMLElement>(); // by the scene

  constructor(
    private readonly done: DoneTasks,
    private readonly choose: (scene: string) => void,
  ) {}

  // The scenes in the order of the tasks, then all others.
  async fill(gallery: SceneGallery): Promise<void> {
    const scenes = await gallery.pictures();
    const order = Object.keys(kTasks);
    const place = (name: string): number => (order.includes(name) ? order.indexOf(name) : order.length);
    scenes.sort((a, b) => place(a.name) - place(b.name));
    this.list.replaceChildren(...scenes.map(({ name, picture }) => this.card(name, picture)));
    this.mark();
  }

  // Which one runs, and which are done.
  mark(running?: string): void {
    for (const [name, card] of this.cards) {
      if (running !== undefined) card.setAttribute('aria-current', String(name === running));
      card.querySelector('.done')!.textContent = this.done.has(name) ? '✓ done' : '';
    }
  }

  private card(name: string, picture: string | undefined): HTMLElement {
    const button = make('button', { type: 'button' }, { scene: name });
    const image = make('img', { alt: '', loading: 'lazy', width: 128, height: 96 });
    if (picture !== undefined) image.src = picture;
    const words = make('span', { className: 'words' });
    words.append(
      make('strong', { textContent: name }),
      ' ',
      make('span', { className: 'done good' }),
      ' ',
      make('span', { className: 'line small', textContent: kTasks[name]?.line ?? '' }),
    );
    button.append(image, words);
    button.addEventListener('click', () => this.choose(name));
    this.cards.set(name, button);
    const item = make('li');
    item.append(button);
    return item;
  }
}
