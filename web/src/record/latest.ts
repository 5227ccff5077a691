/** Keeps one request in progress; of the requests made meanwhile, only the newest is kept. */
export class LatestOnly<Q, A> {
  private waiting: { question: Q } | undefined;
  private busy = false;

  constructor(
    private readonly ask: (question: Q) => Promise<A>,
    private readonly onAnswer: (answer: A, question: Q) => void,
    private readonly onError: (error: unknown) => void,
  ) {}

  /** Sends the request now, or when the one in progress has been answered. */
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
