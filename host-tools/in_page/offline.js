// The service worker of the site, made by make_site.mjs: the site without a network, after the first visit.
const cache_name = 'thimble-VERSION';
const files = FILES;

addEventListener('install', (event) => event.waitUntil(caches.open(cache_name).then((cache) => cache.addAll(files)).then(() => skipWaiting())));
addEventListener('activate', (event) =>
  event.waitUntil(
    caches
      .keys()
      .then((names) => Promise.all(names.filter((name) => name.startsWith('thimble-') && name !== cache_name).map((name) => caches.delete(name))))
      .then(() => clients.claim()),
  ),
);
addEventListener('fetch', (event) => {
  if (event.request.method !== 'GET' || !event.request.url.startsWith(registration.scope)) return;
  event.respondWith(caches.match(event.request, { ignoreSearch: true }).then((kept) => kept ?? fetch(event.request)));
});
