// The button that makes a link to the running scene: copied, and shown to be copied by hand.
import type { Alerts } from './alerts';
import { element, set_text } from './dom';
import { LinkError } from './scene_link';

export function show_share_button(link: () => Promise<string>, alerts: Alerts): void {
  element('share').hidden = false;
  const address = element<HTMLInputElement>('share-address');
  const said = element('share-said');
  address.addEventListener('focus', () => address.select());
  element('share-link').addEventListener('click', () => void make());

  async function make(): Promise<void> {
    set_text(said, '');
    address.value = '';
    try {
      address.value = await link();
    } catch (error) {
      const cause = error instanceof Error ? error.message : String(error);
      const remedy = error instanceof LinkError ? error.remedy : 'load the page again';
      set_text(said, `No link: ${cause}.`);
      alerts.say({ level: 'error', name: 'no-link', cause, remedy });
      return;
    }
    try {
      await navigator.clipboard.writeText(address.value);
      set_text(said, 'The link is copied.');
    } catch {
      set_text(said, 'The browser does not let the page copy it: copy it here.');
      address.focus();
    }
  }
}
