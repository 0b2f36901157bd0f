// States on the way, for going back to any step.

interface State {
  step: number;
  snapshot: string;
}

const MOST_CHARACTERS = 160_000_000;

export class History {
  private states: State[] = [];
  private characters = 0;

  clear(): void {
    this.states = [];
    this.characters = 0;
  }

  copy(): History {
    const other = new History();
    this.states.forEach(({ step, snapshot }) => other.add(step, snapshot));
    return other;
  }

  has(step: number): boolean {
    return this.states.some((state) => state.step === step);
  }

  add(step: number, snapshot: string): void {
    if (this.has(step)) {
      return;
    }
    this.states.push({ step, snapshot });
    this.states.sort((a, b) => a.step - b.step);
    this.characters += snapshot.length;
    // too much: every second state in between goes
    while (this.characters > MOST_CHARACTERS && this.states.length > 2) {
      this.states = this.states.filter((_, i) => i % 2 === 0 || i === this.states.length - 1);
      this.characters = this.states.reduce((sum, state) => sum + state.snapshot.length, 0);
    }
  }

  /** The latest state that is not later than a step. */
  before(step: number): State | null {
    return this.states.filter((state) => state.step <= step).pop() ?? null;
  }
}
