// An input for a number. Typed text stays until it is done: the page is drawn again every few seconds, also between two digits.
import type { JSX } from "preact";
import { useRef, useState } from "preact/hooks";

type Props = Omit<JSX.IntrinsicElements["input"], "value" | "type" | "onInput" | "onChange" | "onBlur"> & {
  value: number | undefined;
  /** The number is written; false: it is refused, and stays as it was typed. */
  onDone: (input: HTMLInputElement) => unknown;
};

export function NumberField({ value, onDone, ...rest }: Props) {
  const [draft, setDraft] = useState<string | null>(null);
  const isRefused = useRef(false);
  return (
    <input {...rest} type="number" value={draft ?? value}
      onInput={(event) => setDraft(event.currentTarget.value)}
      onChange={(event) => {
        isRefused.current = onDone(event.currentTarget) === false;
        setDraft(isRefused.current ? event.currentTarget.value : null);
      }}
      onBlur={() => !isRefused.current && setDraft(null)} />
  );
}
