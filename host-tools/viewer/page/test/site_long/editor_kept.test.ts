// What the editor keeps in this browser: files that were added, and edits that are not saved.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import type { Page } from 'playwright-core';

import { until as until_soon } from '../browser/browser';
import { violations } from '../browser/page_checks';
import { site_in_chromium } from '../site/chromium';

const kTimeout_ms = 120_000;
const until = (what: string, holds: () => Promise<boolean>): Promise<void> => until_soon(what, holds, 60_000);

const site = site_in_chromium();

const text = (page: Page, name: string): Promise<string> => page.getByTestId(name).innerText();
const kept = async (page: Page): Promise<string> => (await page.getByTestId('editor-kept').textContent()) ?? '';
const lines = (page: Page): Promise<string> => page.locator('.cm-content').innerText();
const runs = (page: Page): Promise<void> => until('the text to run', async () => (await text(page, 'editor-state')).startsWith('Runs'));
const has_mesh = async (page: Page): Promise<boolean> =>
  (await page.getByTestId('editor-objects').locator('option').allInnerTexts()).includes('tetra (mesh)');
const x_mm = (page: Page): Promise<string> => page.getByTestId('editor-position-0').inputValue();

// A page of its own storage; refuses: what is run in it before all else.
async function open(refuses?: () => void): Promise<Page> {
  const context = await site.browser.newContext({ viewport: { width: 1280, height: 900 }, deviceScaleFactor: 0.5 });
  if (refuses) await context.addInitScript(refuses);
  const page = await context.newPage();
  await page.goto(site.address);
  await edit(page);
  return page;
}
async function edit(page: Page): Promise<void> {
  await page.getByTestId('edit').click();
  await until('the objects', async () => (await page.getByTestId('editor-objects').locator('option').count()) > 2);
}
async function reload(page: Page): Promise<void> {
  await page.reload();
  await edit(page);
}
async function load(page: Page, scene: string): Promise<void> {
  // At once: the picker follows the scene that runs.
  await page.getByTestId('scene-picker').evaluate((list: HTMLSelectElement, name) => {
    list.value = name;
    list.form?.requestSubmit();
  }, scene);
}
async function move(page: Page, x: number): Promise<void> {
  await page.getByTestId('editor-objects').selectOption({ index: 1 });
  await page.getByTestId('editor-position-0').fill(String(x));
  await page.getByTestId('editor-position-0').press('Enter');
  await runs(page);
}
async function drop(page: Page, name: string, content: string): Promise<void> {
  await page.evaluate(
    ([file, bytes]) => {
      const data = new DataTransfer();
      data.items.add(new File([bytes], file));
      document.body.dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true, cancelable: true }));
    },
    [name, content],
  );
}

const kTetrahedron = 'v 0 0 0\nv 30 0 0\nv 0 30 0\nv 0 0 30\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n';

function refuse_databases(): void {
  IDBFactory.prototype.open = () => {
    throw new DOMException('storage is not allowed here', 'SecurityError');
  };
}
function be_full(): void {
  IDBObjectStore.prototype.put = () => {
    throw new DOMException('no room', 'QuotaExceededError');
  };
}

test('a mesh that was added and edits that were not saved are there after a reload, until they are taken away', async () => {
  const page = await open();
  await drop(page, 'tetra.obj', kTetrahedron);
  await until('the object', () => has_mesh(page));
  await runs(page);
  await until('it among what is kept', async () => (await kept(page)).includes('buttons/tetra.obj, 1 KiB'));

  await reload(page);
  assert.equal(await has_mesh(page), false, 'nothing runs that was not asked for');
  assert.match(await kept(page), /Edits of “buttons”, not saved.*File buttons\/tetra\.obj/);
  await page.getByTestId('editor-restore').click();
  await runs(page);
  assert.equal(await has_mesh(page), true);
  assert.equal(await text(page, 'editor-issues'), '');
  assert.equal(await page.getByTestId('editor-restore').count(), 0);

  await page.getByTestId('editor-remove-file').click();
  await until('the scene to lack it', async () => (await text(page, 'editor-issues')).includes('tetra.obj'));
  assert.ok(!(await kept(page)).includes('File'));
  await reload(page);
  await until('the edits', async () => (await kept(page)).includes('Edits of “buttons”'));
  assert.ok(!(await kept(page)).includes('File'));
  await page.getByTestId('editor-delete-edits').click();
  await until('nothing', async () => !(await page.getByTestId('editor-kept').isVisible()));
  await reload(page);
  assert.equal(await page.getByTestId('editor-kept').isVisible(), false);
  await page.context().close();
});

test(
  'another scene gives up nothing: the edits of the first one wait, also from before an older take',
  { timeout: kTimeout_ms },
  async () => {
    const page = await open();
    await move(page, 41);
    await load(page, 'ring');
    await until('the other scene', async () => (await text(page, 'scene')) === 'ring on a table');
    await until('the edits', async () => (await kept(page)).includes('Edits of “buttons”'));
    assert.match(await text(page, 'messages'), /edits-kept: the edits of "buttons" are not saved; this browser keeps them/);
    assert.ok((await text(page, 'editor-state')) === 'Runs.');

    // Edited again without restoring them: both are kept.
    await page.getByTestId('editor-load-kept').click();
    await until('the scene', async () => (await text(page, 'scene')) === 'buttons');
    await until('its edits', () => page.getByTestId('editor-restore').isVisible());
    await move(page, 42);
    await load(page, 'buttons'); // the same one, from its file
    await until('both', async () => (await page.getByTestId('editor-restore').count()) === 2);
    await page.getByTestId('editor-restore').last().click();
    await until('the older', async () => {
      await page.getByTestId('editor-objects').selectOption({ index: 1 });
      return (await x_mm(page)) === '41';
    });
    await runs(page);
    assert.equal(await page.getByTestId('editor-restore').count(), 1);

    // What is saved is no edit any more.
    await page.getByTestId('editor-save').click();
    await until('it to be saved', async () => (await text(page, 'editor-state')) === 'Runs.');
    await reload(page);
    await page.getByTestId('editor-objects').selectOption({ index: 1 });
    assert.equal(await x_mm(page), '41');
    await until('the newer', async () => (await page.getByTestId('editor-restore').count()) === 1);
    await page.context().close();
  },
);

test('the scene is loaded anew while a text compiles: its file runs, and the text is kept', { timeout: kTimeout_ms }, async () => {
  const page = await open();
  await move(page, 41);
  await page.evaluate(() => {
    const field = document.querySelector<HTMLInputElement>('[data-testid=editor-position-0]')!;
    field.value = '42';
    field.dispatchEvent(new Event('change'));
    document.querySelector<HTMLFormElement>('#picker')!.requestSubmit();
  });
  await until('the file to run', async () => (await text(page, 'editor-state')) === 'Runs.');
  assert.notEqual(await x_mm(page), '42');
  await page.getByTestId('editor-restore').click();
  await until('the text', async () => (await lines(page)).includes('0.042'));
  await until('it to run', async () => (await text(page, 'editor-state')) === 'Runs. Not saved.');
  await page.context().close();
});

test('edits that another tab has in its editor are its own until it is closed', { timeout: kTimeout_ms }, async () => {
  const first = await open();
  await move(first, 41);
  const second = await first.context().newPage();
  await second.goto(site.address);
  await edit(second);
  await move(second, 42);
  assert.equal(await second.getByTestId('editor-kept').isVisible(), false);
  await first.close();
  await load(second, 'buttons');
  await until('both', async () => (await second.getByTestId('editor-restore').count()) === 2);
  await second.getByTestId('editor-restore').last().click();
  await until('the older', async () => (await lines(second)).includes('0.041'));
  await runs(second);
  assert.equal(await second.getByTestId('editor-restore').count(), 1);
  await second.context().close();
});

test('edits of a scene that is no longer there can be downloaded', { timeout: kTimeout_ms }, async () => {
  const page = await open();
  const shared = (): Promise<string> => page.getByTestId('share-address').inputValue();
  await move(page, 43); // so that the link is to another text than that of the gallery
  await page.getByTestId('share-link').click();
  await until('the link', async () => (await shared()).includes('#scene='));
  const address = await shared();
  await page.goto(address);
  await page.reload(); // the fragment alone loads no page
  await edit(page);
  await move(page, 44);
  await page.waitForTimeout(500); // it is stored
  await page.goto('about:blank');
  await page.goto(site.address);
  await edit(page);
  await until('the edits', async () => /Edits of “buttons \(link/.test(await kept(page)));
  const download = page.waitForEvent('download');
  await page.getByTestId('editor-download-kept').click();
  assert.match((await download).suggestedFilename(), /^buttons.*\.scene\.json$/);
  await page.context().close();
});

test('a scene file that is added gives up no edits', { timeout: kTimeout_ms }, async () => {
  const page = await open();
  await move(page, 41);
  const theirs = { thimble_scene: 1, name: 'theirs', objects: [] };
  await drop(page, 'theirs.scene.json', JSON.stringify(theirs));
  await until('its text', async () => (await lines(page)).includes('theirs'));
  await reload(page);
  await until('both', async () => (await page.getByTestId('editor-restore').count()) === 2);
  await page.getByTestId('editor-restore').last().click();
  await until('the older', async () => (await lines(page)).includes('0.041'));
  await page.context().close();
});

test('a text with errors is kept when the editor is closed, and leaving asks nothing', { timeout: kTimeout_ms }, async () => {
  const page = await open();
  const dialogs: string[] = [];
  page.on('dialog', (dialog) => {
    dialogs.push(dialog.type());
    void dialog.accept();
  });
  await page.locator('.cm-content').click();
  await page.keyboard.press('Control+Home');
  await page.keyboard.type('not JSON ');
  await until('an error', async () => (await text(page, 'editor-issues')) !== '');
  await page.getByTestId('editor-close').click();
  await edit(page);
  assert.ok(!(await lines(page)).includes('not JSON'));
  await page.getByTestId('editor-restore').click();
  await until('the text', async () => (await lines(page)).startsWith('not JSON'));
  await page.waitForTimeout(500); // the text is stored
  await page.reload();
  assert.deepEqual(dialogs, []);
  await page.context().close();
});

for (const [what, refuses] of [
  ['refuses storage', refuse_databases],
  ['is full', be_full],
] as const)
  test(
    `a browser that ${what}: it is said, the page works, and nothing is given up without a question`,
    { timeout: kTimeout_ms },
    async () => {
      const page = await open(refuses);
      const dialogs: string[] = [];
      page.on('dialog', (dialog) => {
        dialogs.push(dialog.type());
        void dialog.dismiss();
      });
      await drop(page, 'tetra.obj', kTetrahedron);
      await until('the object', () => has_mesh(page));
      await runs(page);
      assert.equal(await text(page, 'editor-issues'), '');
      const reason = refuses === be_full ? 'its storage is full' : 'storage is not allowed here';
      const banners = await text(page, 'alerts');
      for (const part of ['does not keep tetra.obj', 'does not keep the edits that are not saved', reason])
        assert.ok(banners.includes(part), `${part}: ${banners}`);

      await load(page, 'ring');
      await until('the question', () => page.getByTestId('question').isVisible());
      assert.deepEqual(await violations(page), []);
      // Neither the page nor Stop waits for the answer.
      await page.getByTestId('stop').click();
      await until('the arm to stop', async () => /stop/i.test(await text(page, 'stopped-by')));
      await page.getByTestId('question-no').click();
      assert.equal(await page.getByTestId('question').isVisible(), false);
      assert.equal(await text(page, 'scene'), 'buttons');
      assert.equal(await has_mesh(page), true);
      await page.close({ runBeforeUnload: true });
      await until('the browser to ask', async () => dialogs.length === 1);
      assert.deepEqual(dialogs, ['beforeunload']);
      await load(page, 'ring');
      await page.getByTestId('question-yes').click();
      await until('the other scene', async () => (await text(page, 'scene')) === 'ring on a table');
      assert.deepEqual(dialogs, ['beforeunload']);
      await page.context().close();
    },
  );

test('what was kept of a scene stays until its original is really loaded', { timeout: kTimeout_ms }, async () => {
  const page = await open(refuse_databases);
  const kept_scene = (): Promise<string | null> => page.evaluate(() => localStorage.getItem('thimble-scene:buttons.scene.json'));
  await move(page, 41);
  await page.getByTestId('editor-save').click();
  await until('it to be saved', async () => (await text(page, 'editor-state')) === 'Runs.');
  await move(page, 42);
  await page.getByTestId('editor-original').click();
  await page.getByTestId('question-no').click();
  assert.match((await kept_scene()) ?? '', /0\.041/);
  await page.getByTestId('editor-original').click();
  await page.getByTestId('question-yes').click();
  await until('the original', async () => !['41', '42'].includes(await x_mm(page)));
  await until('it to run', async () => (await text(page, 'editor-state')) === 'Runs.');
  assert.equal(await kept_scene(), null);
  await page.context().close();
});

test('a scene that the browser does not keep is told as not saved', { timeout: kTimeout_ms }, async () => {
  const page = await open(() => {
    Storage.prototype.setItem = () => {
      throw new DOMException('no room', 'QuotaExceededError');
    };
  });
  await move(page, 41);
  await page.getByTestId('editor-save').click();
  await until('the banner', async () => (await text(page, 'alerts')).includes('does not keep the scene: its storage is full'));
  await runs(page);
  assert.match(await text(page, 'editor-state'), /Not saved/);
  await reload(page);
  await until('the edits', () => page.getByTestId('editor-restore').isVisible());
  await page.context().close();
});
