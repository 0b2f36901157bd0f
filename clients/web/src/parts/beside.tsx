// The right half of the stage when there are two plants: a fork, seen from where the first plant is seen.
import { useEffect, useRef } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { View } from "../view/scene.js";
import { IconButton } from "./icons.js";

export function BesideStage({ studio }: { studio: Studio }) {
  const place = useRef<HTMLDivElement>(null);
  const view = useRef<View | null>(null);
  const { beside } = studio;
  useEffect(() => {
    const made = new View(place.current!, studio.view!.settings);
    view.current = made;
    void studio.act(() => beside.attach(made));
    return () => {
      view.current = null;
      void beside.attach(null);
      made.dispose();
    };
  }, []);
  useEffect(() => {
    // colours, shadows and ground are chosen for both
    if (view.current && view.current.settings !== studio.view!.settings) {
      view.current.apply(studio.view!.settings);
    }
  });
  const growth = beside.growth!;
  return (
    <>
      <div id="plant-beside" ref={place} role="img" aria-label={`The plant beside at step ${growth.step}`} />
      <div class="beside">
        <span class="chip" id="beside-state">fork of step {beside.forkStep}, now step {growth.step}: {beside.modules.toLocaleString("en")} modules</span>
        <label class="chip" title="This plant goes to the step of the other one"><input type="checkbox" checked={beside.isTogether} onChange={(event) => { beside.isTogether = event.currentTarget.checked; studio.changed(); }} />same step</label>
        <button type="button" id="swap" class="chip" title="This plant goes to the left, where it is changed" onClick={() => void studio.act(() => beside.swap())}>change this one</button>
        <IconButton icon="close" label="Without this plant (B)" onClick={() => void studio.act(() => beside.close())} />
      </div>
    </>
  );
}
