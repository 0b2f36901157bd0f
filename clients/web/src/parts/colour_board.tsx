// The colours of a published folder that the plant uses; a change goes into the colour map or the materials.
import { useState } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { materialOf, paletteFile, withColour, withMaterial } from "../studio/palette.js";
import type { Material } from "../studio/palette.js";

const MOST = 48;

const hex = (colour: number[]): string => `#${colour.map((value) => value.toString(16).padStart(2, "0")).join("")}`;
const numbers = (text: string): [number, number, number] => [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16)) as [number, number, number];

const COLOURS = [
  ["diffuse", "in the light"],
  ["ambient", "in the shade, in pictures of espalier run"],
  ["emission", "glow"],
  ["specular", "highlights"],
] as const;
const LEVELS = [
  ["shininess", "sharper highlights", 128],
  ["transparency", "seen through", 255],
] as const;

/** Everything that a file of materials says about one of them. */
function MaterialForm({ index, material, onChange }: { index: number; material: Material; onChange: (parts: Partial<Material>) => void }) {
  return (
    <fieldset class="material" id="material">
      <legend>Material {index}</legend>
      {COLOURS.map(([name, meaning]) => (
        <label key={name} title={meaning}>{name}<small>{meaning.split(",")[0]}</small>
          <input type="color" id={`material-${name}`} value={hex(material[name])} onInput={(event) => onChange({ [name]: numbers(event.currentTarget.value) })} />
        </label>
      ))}
      {LEVELS.map(([name, meaning, most]) => (
        <label key={name} title={`${meaning}, 0 to ${most}`}>{name}<small>{material[name]}</small>
          <input type="range" id={`material-${name}`} min={0} max={most} step={1} value={material[name]} onInput={(event) => onChange({ [name]: event.currentTarget.valueAsNumber })} />
        </label>
      ))}
    </fieldset>
  );
}

export function ColourBoard({ studio }: { studio: Studio }) {
  const [chosen, setChosen] = useState<number | null>(null);
  const name = studio.isOwn ? paletteFile(studio.document) : null;
  const used = name ? (studio.view?.usedColours() ?? []) : [];
  if (!name || used.length === 0) {
    return null;
  }
  const hasMaterials = name.endsWith(".mat");
  // the page may not be drawn between two changes: each begins with the file as it is now
  const change = (changed: (bytes: string) => string) => void studio.act(() => studio.recolour(name, changed(studio.document.binary[name])));
  const choose = (index: number) => {
    setChosen(index === chosen ? null : index);
    if (index !== chosen) {
      void studio.act(() => studio.extras.setMaterialsShown(true));
    }
  };
  return (
    <section class="colours" aria-label={`Colours of ${name}`}>
      <h3>Colours of {name}</h3>
      <div class="row wrap">
        {used.slice(0, MOST).map((index) => (
          <div key={index} class="swatch">
            <input type="color" id={`colour-${index}`} title={`Colour ${index}`} aria-label={`Colour ${index}`} value={hex(studio.palette?.colours[index] ?? [255, 255, 255])} onInput={({ currentTarget: { value } }) => change((bytes) => withColour(name, bytes, index, numbers(value)))} />
            {hasMaterials
              ? <button type="button" class="link" aria-expanded={index === chosen} title={`Everything about material ${index}`} onClick={() => choose(index)}>{index} …</button>
              : <span>{index}</span>}
          </div>
        ))}
      </div>
      {used.length > MOST && <p class="quiet">The plant uses {used.length} colours; the first {MOST} are here.</p>}
      {hasMaterials && chosen !== null && used.includes(chosen) && <MaterialForm index={chosen} material={materialOf(studio.document.binary[name], chosen)} onChange={(parts) => change((bytes) => withMaterial(bytes, chosen, parts))} />}
    </section>
  );
}
