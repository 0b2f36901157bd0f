// A control panel of a published folder, as its folder lays it out.
import { useState } from "preact/hooks";
import type { Studio } from "../studio/studio.js";
import { fileOf } from "../studio/document.js";
import { applyMessage, isPanel, parsePanel, targetOf, valueInText } from "../studio/panel.js";
import type { PanelItem } from "../studio/panel.js";
import { useChanges } from "./changes.js";

export const panelsOf = (studio: Studio): string[] => Object.keys(studio.document.files).filter((name) => isPanel(studio.document.files[name]));

export function Panels({ studio }: { studio: Studio }) {
  useChanges(studio);
  return <>{panelsOf(studio).map((name) => <OnePanel key={`${studio.document.title} ${name}`} studio={studio} name={name} />)}</>;
}

function OnePanel({ studio, name }: { studio: Studio; name: string }) {
  const { files, main } = studio.document;
  const panel = parsePanel(files[name]);
  const { file: target, editor } = targetOf(files, name, fileOf(main));
  const [page, setPage] = useState(0);
  const [values, setValues] = useState<Record<number, number>>({});
  const write = (message: string, value: number) => void studio.act(() => studio.editContinuously(target, applyMessage(studio.document.files[target], message, value, editor)));
  const send = (item: PanelItem, index: number, value: number) => {
    const others = item.group === null ? {} : Object.fromEntries(panel.items.map((other, i) => [i, other.group === item.group ? 0 : (values[i] ?? other.value)]));
    setValues({ ...values, ...others, [index]: value });
    if (item.message) {
      write(item.message, value);
    }
  };
  return (
    <section class="published" aria-label={panel.title}>
      <h3>{panel.title} <span class="quiet">– changes {target}</span></h3>
      {panel.pages.length > 1 && (
        <select aria-label={`Page of ${panel.title}`} value={page} onChange={(event) => {
          const chosen = Number(event.currentTarget.value);
          setPage(chosen);
          if (panel.pages[chosen].message) {
            write(panel.pages[chosen].message, 0);
          }
        }}>
          {panel.pages.map(({ name: title }, i) => <option key={i} value={i}>{title}</option>)}
        </select>
      )}
      <div class="board" style={{ width: `${panel.width}px`, height: `${panel.height}px`, background: panel.background }}>
        {panel.items.map((item, i) => {
          if (item.type === "menu" || item.page !== page) {
            return null;
          }
          const place = { left: `${item.x}px`, top: `${item.y}px`, color: item.colours[0] || "#fff" };
          // the panel may show another value than the file has: the file's counts
          const inText = item.type === "slider" ? valueInText(files[target] ?? "", item, editor) : null;
          const value = inText ?? values[i] ?? item.value;
          if (item.type === "label") {
            return <span key={i} class="item" style={place}>{item.name}</span>;
          }
          const shown = item.name.split("%Copy")[0];
          if (item.type === "button") {
            const isOn = (values[i] ?? item.value) === 1;
            // on while it is pressed, by the mouse or by a key
            const hold = (isPressed: boolean) => isPressed !== isOn && send(item, i, isPressed ? 1 : 0);
            const isKey = ({ key, repeat }: KeyboardEvent) => !repeat && (key === " " || key === "Enter");
            const held = item.value === 2 && {
              onPointerDown: () => hold(true), onPointerUp: () => hold(false), onPointerLeave: () => hold(false),
              onKeyDown: (event: KeyboardEvent) => isKey(event) && hold(true), onKeyUp: (event: KeyboardEvent) => isKey(event) && hold(false),
            };
            const press = () => send(item, i, item.group !== null || !isOn ? 1 : 0);
            return <button key={i} type="button" class="item press" style={{ ...place, background: (isOn ? item.colours[1] : item.colours[2]) || "#222" }} aria-pressed={isOn} {...(held || { onClick: press })}>{shown}</button>;
          }
          return (
            <label key={i} class="item slide" style={{ ...place, accentColor: item.colours[1] || "#c22" }}>
              <output>{value}{value < item.low || value > item.high || !Number.isInteger(value) ? " *" : ""}</output>
              <input type="range" min={item.low} max={item.high} step={1} value={value} onInput={(event) => send(item, i, Number(event.currentTarget.value))} />
              {shown}
            </label>
          );
        })}
      </div>
      {panel.items.map((item, i) => item.type === "menu" && <button key={i} type="button" disabled={!item.message} onClick={() => write(item.message, 0)}>{item.name}</button>)}
      {panel.problems.map((problem) => <p key={problem} class="error">{name}, {problem}</p>)}
    </section>
  );
}
