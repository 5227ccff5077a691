/** Goals and causes of PDL as phrases, with arguments shown on demand. Pure. */

/** Names of targets by identifier. */
export type Names = ReadonlyMap<string, string>;

/** Words that introduce an argument; without the argument they are removed from the end of a phrase. */
const LEADS = new Set(
  'from to along once due before after at on with for over by until of as and again more'.split(' '),
);

/** `observe Butler 2`, for `(observe butler-2 along (((34.3 ..))) due P3H)`. */
export function phrase(goal: string, names: Names): string {
  const inner = goal.startsWith('(') ? goal.replace(/^\(|\)$/g, '') : goal;
  const plain = withoutLists(inner, '');
  const words = plain
    .split(/\s+/)
    .filter(word => word !== '' && word !== '..' && !word.startsWith('?') && !/^P\d/.test(word));
  while (words.length > 1 && LEADS.has(words.at(-1) ?? '')) words.pop();
  // `observe Butler 2 along due` keeps no introducing word in front of another one.
  const kept = words.filter((word, index) => !(LEADS.has(word) && LEADS.has(words[index + 1] ?? '')));
  const text = kept.map(word => names.get(word) ?? word.replaceAll('-', ' ')).join(' ');
  return text === '' ? goal : text;
}

/** A text without its lists of numbers, and with goals as phrases. */
export function brief(sentence: string, names: Names): string {
  let text = '';
  for (let at = 0; at < sentence.length; ) {
    const end = sentence[at] === '(' ? closing(sentence, at) : -1;
    if (end < 0) {
      // A goal without its closing parenthesis was cut off: its words are kept.
      if (sentence[at] === '(' && /[a-z]/i.test(sentence[at + 1] ?? '')) at += 1;
      text += sentence[at];
      at += 1;
      continue;
    }
    const list = sentence.slice(at, end + 1);
    text += /^\(\(*-?[\d.]/.test(list) ? '…' : phrase(list, names);
    at = end + 1;
  }
  return text.replace(/\s+/g, ' ').trim();
}

/** `text` with its parenthesised parts replaced. */
function withoutLists(text: string, by: string): string {
  let found = '';
  let depth = 0;
  for (const letter of text) {
    if (letter === '(') depth += 1;
    if (depth === 0) found += letter;
    else if (letter === ')' && depth === 1) found += by;
    if (letter === ')') depth = Math.max(0, depth - 1);
  }
  return found;
}

/** The position at which the parenthesis at `from` closes; -1 if it does not. */
function closing(text: string, from: number): number {
  let depth = 0;
  for (let at = from; at < text.length; at += 1) {
    if (text[at] === '(') depth += 1;
    if (text[at] === ')') depth -= 1;
    if (depth === 0) return at;
  }
  return -1;
}
