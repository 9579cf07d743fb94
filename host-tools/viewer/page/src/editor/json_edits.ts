// Changes of a JSON text with comments, as edits that leave everything else as it is: formatting, comments, the order of keys. Offsets of all edits
// of one change are those of the text before it.
import { type Edit, type JSONPath, type Node, createScanner, findNodeAtLocation, parseTree } from 'jsonc-parser';

export type { Edit, JSONPath, Node };
export type Json = null | boolean | number | string | Json[] | { [key: string]: Json };

export class NotJson extends Error {}

// The tree of a text. Throws NotJson where the text has none.
export function tree_of(text: string): Node {
  const root = parseTree(text, [], { allowTrailingComma: true });
  if (root === undefined) throw new NotJson('the text is not JSON');
  return root;
}

export const apply = (text: string, edits: readonly Edit[]): string =>
  [...edits]
    .sort((a, b) => b.offset - a.offset)
    .reduce((now, { offset, length, content }) => now.slice(0, offset) + content + now.slice(offset + length), text);

// In one line, as people write it.
export function print(value: Json): string {
  if (Array.isArray(value)) return `[${value.map(print).join(', ')}]`;
  if (typeof value !== 'object' || value === null) return JSON.stringify(value);
  const members = Object.entries(value).map(([key, one]) => `${JSON.stringify(key)}: ${print(one)}`);
  return members.length === 0 ? '{}' : `{ ${members.join(', ')} }`;
}

const kMostColumns = 110;

// As print(), but with a line for each member where one line would be too long.
export function print_lines(value: { [key: string]: Json }, indentation: string): string {
  const line = print(value);
  if (line.length <= kMostColumns) return line;
  const members = Object.entries(value).map(([key, one]) => {
    const inner = `${indentation}  `;
    const is_object = typeof one === 'object' && one !== null && !Array.isArray(one);
    return `${inner}${JSON.stringify(key)}: ${is_object ? print_lines(one, inner) : print(one)}`;
  });
  return `{\n${members.join(',\n')}\n${indentation}}`;
}

// The value at this path becomes the one given; objects on the way that are missing are made. Of arrays of the same length only the elements that
// differ are touched, and a value that is there already is left as it is written.
export function set_value(text: string, path: JSONPath, value: Json): Edit[] {
  const root = tree_of(text);
  const node = findNodeAtLocation(root, path);
  if (node !== undefined) return replace(node, value);
  const key = path[path.length - 1];
  const above = path.slice(0, -1);
  const parent = findNodeAtLocation(root, above);
  if (parent === undefined) return set_value(text, above, { [key]: value });
  if (parent.type !== 'object') return [{ offset: parent.offset, length: parent.length, content: print({ [key]: value }) }];
  return append(text, parent, `${JSON.stringify(key)}: ${print(value)}`);
}

function replace(node: Node, value: Json): Edit[] {
  const elements = node.children ?? [];
  if (Array.isArray(value) && node.type === 'array' && elements.length === value.length)
    return value.flatMap((one, i) => replace(elements[i], one));
  const same = (node.type === 'number' || node.type === 'string' || node.type === 'boolean') && node.value === value;
  return same ? [] : [{ offset: node.offset, length: node.length, content: print(value) }];
}

// A new element of an array, behind the element `after`, or at the end. content: its text.
export function insert_element(text: string, path: JSONPath, content: string, after?: number): Edit[] {
  const array = findNodeAtLocation(tree_of(text), path);
  if (array?.type !== 'array') throw new NotJson(`the text has no array ${path.join('/')}`);
  const elements = array.children ?? [];
  return append(text, array, content, after === undefined ? elements.at(-1) : elements[after]);
}

// An element of an array, with its comma. Comments before it, and behind it, stay.
export function remove_element(text: string, path: JSONPath, index: number): Edit[] {
  const array = findNodeAtLocation(tree_of(text), path);
  const elements = array?.children ?? [];
  const node = elements[index];
  if (node === undefined) throw new NotJson(`the text has no ${path.join('/')}/${index}`);
  const begin = start_of_gap(text, node.offset);
  const end = node.offset + node.length;
  const comma = comma_after(text, end);
  if (comma !== null) {
    const joined = text.slice(end, comma).trim() === '';
    if (joined) return [{ offset: begin, length: comma + 1 - begin, content: '' }];
    return [
      { offset: begin, length: end - begin, content: '' },
      { offset: comma, length: 1, content: '' },
    ];
  }
  const edits = [{ offset: begin, length: end - begin, content: '' }];
  const before = elements[index - 1];
  const last = before === undefined ? null : comma_after(text, before.offset + before.length);
  if (last !== null) edits.unshift({ offset: last, length: 1, content: '' });
  return last === begin - 1 ? [{ offset: last, length: end - last, content: '' }] : edits;
}

// Another name for a key of an object.
export function rename_key(text: string, path: JSONPath, name: string): Edit[] {
  const key = findNodeAtLocation(tree_of(text), path)?.parent?.children?.[0];
  if (key === undefined) return [];
  return [{ offset: key.offset, length: key.length, content: JSON.stringify(name) }];
}

// Behind `last`, or the last member, of an object or array: in a line of its own where the members are.
function append(text: string, parent: Node, content: string, last: Node | undefined = parent.children?.at(-1)): Edit[] {
  if (last === undefined) {
    const blank = parent.type === 'object' ? ' ' : '';
    const open = text.slice(parent.offset + 1, parent.offset + parent.length - 1);
    if (open.trim() === '') return [{ offset: parent.offset + 1, length: open.length, content: `${blank}${content}${blank}` }];
    return [{ offset: parent.offset + parent.length - 1, length: 0, content: `${end_of_line(text)}${content}${end_of_line(text)}` }];
  }
  const end = last.offset + last.length;
  const gap = text.slice(start_of_gap(text, last.offset), last.offset);
  const own_line = gap.includes('\n');
  const comma = comma_after(text, end);
  // A comment behind a member in its line is about that member.
  const place = own_line ? end_of_remarks(text, comma === null ? end : comma + 1) : comma === null ? end : comma + 1;
  const between = own_line ? gap : ' ';
  if (comma !== null) return [{ offset: place, length: 0, content: `${between}${content},` }];
  if (place === end) return [{ offset: end, length: 0, content: `,${between}${content}` }];
  return [
    { offset: end, length: 0, content: ',' },
    { offset: place, length: 0, content: `${between}${content}` },
  ];
}

const end_of_line = (text: string): string => (text.includes('\r\n') ? '\r\n' : '\n');

// Where the blanks before an offset begin, at most one line's end of them.
function start_of_gap(text: string, offset: number): number {
  let begin = offset;
  while (begin > 0 && (text[begin - 1] === ' ' || text[begin - 1] === '\t')) --begin;
  if (text[begin - 1] !== '\n') return begin;
  return text[begin - 2] === '\r' ? begin - 2 : begin - 1;
}

// The comma behind a value; null: it is the last.
function comma_after(text: string, offset: number): number | null {
  const scanner = createScanner(text, true);
  scanner.setPosition(offset);
  scanner.scan();
  return text[scanner.getTokenOffset()] === ',' ? scanner.getTokenOffset() : null;
}

function end_of_remarks(text: string, offset: number): number {
  const scanner = createScanner(text, false);
  scanner.setPosition(offset);
  for (let end = offset; ;) {
    scanner.scan();
    const token = text.slice(scanner.getTokenOffset(), scanner.getTokenOffset() + scanner.getTokenLength());
    const is_remark = token.startsWith('//') || token.startsWith('/*');
    if (is_remark) end = scanner.getTokenOffset() + token.length;
    if (token.startsWith('//') || (!is_remark && (token === '' || token.includes('\n') || token.trim() !== ''))) return end;
  }
}
