/** Keeps one question under way: while it is, only the newest of the questions that follow is kept. */
export class LatestOnly<Q, A> {
  private waiting: { question: Q } | undefined;
  private busy = false;

  constructor(
    private readonly ask: (question: Q) => Promise<A>,
    private readonly onAnswer: (answer: A, question: Q) => void,
    private readonly onError: (error: unknown) => void,
  ) {}

  /** Asks now, or when the question under way is answered. */
  put(question: Q): void {
    this.waiting = { question };
    if (!this.busy) void this.run();
  }

  private async run(): Promise<void> {
    this.busy = true;
    while (this.waiting) {
      const { question } = this.waiting;
      this.waiting = undefined;
      try {
        this.onAnswer(await this.ask(question), question);
      } catch (error) {
        this.onError(error);
      }
    }
    this.busy = false;
  }
}
