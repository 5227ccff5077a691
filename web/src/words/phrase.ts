/** Goals and causes of PDL as phrases, with arguments shown on demand. Pure. */

/** Names of targets by identifier. */
export type Names = ReadonlyMap<string, string>;

/** Words that introduce an argument; without the argument they are removed from the end of a phrase. */
const LEADS = new Set(
  'from to along once due before after at on with for over by until of as and again more because unless where if'.split(
    ' ',
  ),
);

/** Represents an argument that is left out. */
const ARGUMENT = '\u0000';

/** `observe Butler 2`, for `(observe butler-2 along (((34.3 ..))) due P3H)`: the words before the first argument that is left out, and
 * targets after it. */
export function phrase(goal: string, names: Names): string {
  const inner = goal.startsWith('(') ? goal.replace(/^\(|\)$/g, '') : goal;
  const plain = withoutLists(inner.replace(/"[^"]*"?/g, ` ${ARGUMENT} `), ` ${ARGUMENT} `);
  const words = plain.split(/\s+/).filter(word => word !== '' && word !== '..');
  const first = words.findIndex(isArgument);
  const end = first < 0 ? words.length : first;
  const kept = words.filter(
    (word, index) => index < end || names.has(word) || (LEADS.has(word) && names.has(words[index + 1] ?? '')),
  );
  // `observe Butler 2 along due` keeps no introducing word without its argument.
  const said = kept.filter((word, index) => !(LEADS.has(word) && LEADS.has(kept[index + 1] ?? '')));
  while (said.length > 1 && LEADS.has(said.at(-1) ?? '')) said.pop();
  const text = said.map(word => names.get(word) ?? word.replaceAll('-', ' ')).join(' ');
  return text === '' ? goal : text;
}

function isArgument(word: string): boolean {
  return word === ARGUMENT || word.startsWith('?') || word.startsWith(':') || /^P\d/.test(word);
}

/** `photograph Flange 15`, for a phrase of more words: those up to the first target; all of them without one. */
export function untilTarget(goal: string, names: Names): string {
  const words = (goal.startsWith('(') ? goal.replace(/^\(|\)$/g, '') : goal).split(/\s+/);
  const at = words.findIndex(word => names.has(word));
  return phrase(at < 0 ? goal : `(${words.slice(0, at + 1).join(' ')})`, names);
}

/** `segment weighed Fool Creek`, for a message: its words before the first number, and its target. */
export function eventWords(form: string, names: Names): string {
  const plain = withoutLists(form.replace(/^\(|\)$/g, '').replace(/"[^"]*"?/g, ''), ' ');
  const words = plain.split(/\s+/).filter(Boolean);
  const end = words.findIndex(word => /^[-+]?\d/.test(word));
  return phrase(`(${words.slice(0, end < 0 ? undefined : end).join(' ')})`, names);
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
