/** The last answers of the server, so that an equal answer is the same object: what is drawn from it needs no new drawing. */

/** Maximum number of kept answers, and maximum length of one, in characters. */
const [ANSWERS_MAX, LENGTH_MAX] = [64, 2_000_000];

export class Answers {
  /** The last answer to each question, without the instants of the question; the oldest first. */
  private readonly last = new Map<string, { text: string; body: unknown }>();

  /** The content of an answer: the object of the last answer to the question if both have the same text. It must not be changed. */
  decode(question: string, text: string): unknown {
    const known = this.last.get(question);
    this.last.delete(question);
    const kept = known?.text === text ? known : { text, body: JSON.parse(text) as unknown };
    if (text.length <= LENGTH_MAX) this.last.set(question, kept);
    for (const oldest of this.last.keys()) {
      if (this.last.size <= ANSWERS_MAX) break;
      this.last.delete(oldest);
    }
    return kept.body;
  }
}
