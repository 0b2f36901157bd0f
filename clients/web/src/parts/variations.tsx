// A table of plants over two numbers of the model, or over seeds. A click takes a plant over.
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { SIDE, axisOf, growVariations, seedAxis, shapeOf, takeOver, variationsOf } from "../studio/variations.js";
import type { Axis, Variation } from "../studio/variations.js";
import { View } from "../view/scene.js";
import { Dialog } from "./dialogs.js";
import { NumberField } from "./number_field.js";

// between two changes of the table: each has the browser draw the whole page again
const TABLE_MILLISECONDS = 200;

const short = (value: number): string => String(Number(value.toPrecision(4)));

/** The choice of what changes along a side, and between which values. */
function AxisChoice({ studio, label, axis, onChange }: { studio: Studio; label: string; axis: Axis; onChange: (axis: Axis) => void }) {
  const choose = (name: string) => onChange(name === "" ? seedAxis() : axisOf(studio.defines.find((define) => define.name === name)!));
  const bound = (side: "low" | "high") => (
    <NumberField step={axis.step} value={axis[side]} aria-label={`${side === "low" ? "First" : "Last"} value ${label}`}
      onDone={({ valueAsNumber }) => Number.isFinite(valueAsNumber) && onChange({ ...axis, [side]: valueAsNumber })} />
  );
  return (
    <div class="axis">
      <label>
        {label}{" "}
        <select value={axis.name} onChange={(event) => choose(event.currentTarget.value)}>
          {studio.defines.map(({ file, name }) => <option key={`${file} ${name}`} value={name}>{name}</option>)}
          <option value="">seed</option>
        </select>
      </label>
      {axis.name !== "" && <>{bound("low")} … {bound("high")}</>}
    </div>
  );
}

export function VariationsDialog({ studio, onClose }: { studio: Studio; onClose: () => void }) {
  const [across, setAcross] = useState<Axis>(() => (studio.defines[0] ? axisOf(studio.defines[0]) : seedAxis()));
  const [down, setDown] = useState<Axis>(() => (studio.defines[1] ? axisOf(studio.defines[1]) : seedAxis()));
  const [pictures, setPictures] = useState<Record<string, string>>({});
  const [shapes, setShapes] = useState<Set<string>>(new Set()); // that were seen
  const [problem, setProblem] = useState("");
  const stage = useRef<HTMLDivElement>(null);
  const view = useRef<View | null>(null);
  const isClosed = useRef(false);
  const [firstSeed, setFirstSeed] = useState(studio.seed);
  const hasSeeds = across.name === "" || down.name === "";
  const variations = useMemo(() => variationsOf(across, down, firstSeed), [across, down, firstSeed]);
  const keyOf = ({ row, column }: Variation) => `${row} ${column}`;
  useEffect(() => {
    const made = new View(stage.current!, { ...studio.view!.settings, mode: "model", hasShadows: false, hasGround: false });
    made.isOfPictures = true;
    made.setBackground(false); // it is that of the card
    made.setPalette(studio.palette);
    view.current = made;
    return () => {
      isClosed.current = true;
      made.dispose();
    };
  }, []);
  useEffect(() => {
    const stop = new AbortController();
    const made: Record<string, string> = {};
    const seen = new Set<string>();
    const show = () => {
      setPictures({ ...made });
      setShapes(new Set(seen));
    };
    show();
    setProblem("");
    const showing = setInterval(() => Object.keys(made).length > 0 && show(), TABLE_MILLISECONDS);
    growVariations(studio, variations, (grown) => {
      if (!stop.signal.aborted && !isClosed.current) {
        made[keyOf(grown)] = view.current!.pictureOf(grown.geometry, grown.change, studio.view!);
        seen.add(shapeOf(grown.geometry));
        if (Object.keys(made).length === variations.length) {
          show();
        }
      }
    }, stop.signal)
      .catch((error: Error) => setProblem(error.message))
      .finally(() => {
        clearInterval(showing);
        if (!stop.signal.aborted) {
          show();
        }
      });
    return () => {
      clearInterval(showing);
      stop.abort();
    };
  }, [variations]);
  const take = (one: Variation) => {
    onClose();
    void studio.act(() => takeOver(studio, one, { [across.name]: across.step, [down.name]: down.step }));
  };
  const nameOf = ({ values, seed }: Variation) =>
    [...Object.entries(values).map(([name, value]) => `${name} ${short(value)}`), ...(hasSeeds ? [`seed ${seed}`] : [])].join(", ");
  const count = Object.keys(pictures).length;
  return (
    <Dialog title="Variations" class="variations" onClose={onClose}>
      <div class="row">
        <AxisChoice studio={studio} label="across" axis={across} onChange={setAcross} />
        <AxisChoice studio={studio} label="down" axis={down} onChange={setDown} />
        {hasSeeds && <label>seeds from <NumberField class="seeds" id="first-seed" min={0} step={1} value={firstSeed} onDone={({ valueAsNumber }) => Number.isInteger(valueAsNumber) && setFirstSeed(valueAsNumber)} /></label>}
        {hasSeeds && <button type="button" id="more-seeds" title="Seeds that the table has not shown" onClick={() => setFirstSeed(Math.max(...variations.map(({ seed }) => seed)) + 1)}>next seeds</button>}
        <span class="quiet">{count} of {SIDE * SIDE}, at step {studio.step}. A click takes a plant over.</span>
        {count > SIDE && shapes.size === 1 && <span class="error" role="alert">All are the same{count < variations.length ? " so far" : ""}: {across.name === "" && down.name === "" ? "the model draws no random numbers. Choose a number of the model on a side." : "the plant does not depend on these numbers."}</span>}
      </div>
      {problem && <p class="error">{problem}</p>}
      <div class="scroll">
        <div class="table">
          {variations.map((one) => (
            <button type="button" class="card" key={keyOf(one)} data-variation={keyOf(one)} aria-label={nameOf(one)} title={nameOf(one)} onClick={() => take(one)}>
              <div class="picture">{pictures[keyOf(one)] && <img src={pictures[keyOf(one)]} alt="" />}</div>
              <span>{nameOf(one)}</span>
            </button>
          ))}
        </div>
      </div>
      <div ref={stage} class="aside" aria-hidden="true" />
    </Dialog>
  );
}
