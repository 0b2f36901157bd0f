// The colours of a published folder that the plant uses; a change goes into the colour map or the materials.
import type { Studio } from "../studio/studio.js";
import { paletteFile, withColour } from "../studio/palette.js";

const MOST = 48;

const hex = (colour: number[]): string => `#${colour.map((value) => value.toString(16).padStart(2, "0")).join("")}`;
const numbers = (text: string): [number, number, number] => [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16)) as [number, number, number];

export function ColourBoard({ studio }: { studio: Studio }) {
  const name = studio.isOwn ? paletteFile(studio.document) : null;
  const used = name ? (studio.view?.usedColours() ?? []) : [];
  if (!name || used.length === 0) {
    return null;
  }
  const change = (index: number, text: string) => {
    const changed = withColour(name, studio.document.binary[name], index, numbers(text));
    if (changed === null) {
      studio.say(`${name} has no material ${index}. Choose another colour in the model.`, true);
    } else {
      void studio.act(() => studio.recolour(name, changed));
    }
  };
  return (
    <section class="colours" aria-label={`Colours of ${name}`}>
      <h3>Colours of {name}</h3>
      <div class="row wrap">
        {used.slice(0, MOST).map((index) => (
          <label key={index} class="swatch" title={`Colour ${index}`}>
            <input type="color" id={`colour-${index}`} value={hex(studio.palette?.colours[index] ?? [255, 255, 255])} onInput={(event) => change(index, event.currentTarget.value)} />
            <span>{index}</span>
          </label>
        ))}
      </div>
      {used.length > MOST && <p class="quiet">The plant uses {used.length} colours; the first {MOST} are here.</p>}
    </section>
  );
}
