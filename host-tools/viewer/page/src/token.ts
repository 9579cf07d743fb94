// The query with the token, as the server wants it. It comes with the address of the page and is taken out of it: the address bar, the
// history and bookmarks do not keep it. A reload of this tab finds it in the tab's own storage, which no other port or site can read.
const kKey = 'thimble-query';

export function take_query(): string {
  const query = location.search;
  try {
    if (query === '') return sessionStorage.getItem(kKey) ?? '';
    sessionStorage.setItem(kKey, query);
  } catch {
    return query; // without storage a reload needs the address
  }
  history.replaceState(history.state, '', location.pathname + location.hash);
  return query;
}
