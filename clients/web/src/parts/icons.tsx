// The pictures of buttons.
const PATHS: Record<string, string> = {
  play: "M7 4.5v15l12-7.5z",
  pause: "M7 5h3.5v14H7zM13.5 5H17v14h-3.5z",
  step: "M6 5v14l9-7zM16.5 5H19v14h-2.5z",
  back: "M18 5v14l-9-7zM7.5 5H5v14h2.5z",
  first: "M19 5v14l-8-7zM11 5v14l-8-7zM3 5h0",
  fork: "M12 20v-7M12 13C12 9 7 10 7 5M12 13c0-4 5-3 5-8M4.5 7L7 4.500 9.500 7M14.500 7L17 4.500 19.500 7",
  gallery: "M4 4h7v7H4zM13 4h7v7h-7zM4 13h7v7H4zM13 13h7v7h-7z",
  fit: "M4 9V4h5v2H6v3zM15 4h5v5h-2V6h-3zM4 15h2v3h3v2H4zM18 15h2v5h-5v-2h3z",
  share: "M15 8l-6 3.5M9 13l6 3.5M17.5 9a2.5 2.5 0 100-5 2.5 2.5 0 000 5zM6.5 14.7a2.5 2.5 0 100-5 2.5 2.5 0 000 5zM17.5 20a2.5 2.5 0 100-5 2.5 2.5 0 000 5z",
  save: "M12 4v11m0 0l-4.5-4.5M12 15l4.5-4.5M5 19h14",
  help: "M9.2 9a2.9 2.9 0 115 2c-1.200 1-2.200 1.500-2.200 3M12 17.500v.5",
  moon: "M20 14.500A8 8 0 119.500 4a6.500 6.500 0 0010.500 10.500z",
  sun: "M12 8a4 4 0 100 8 4 4 0 000-8zM12 2.500V5M12 19v2.500M2.500 12H5M19 12h2.500M5.300 5.300L7 7M17 17l1.700 1.700M18.700 5.300L17 7M7 17l-1.700 1.700",
  close: "M6 6l12 12M18 6L6 18",
  plus: "M12 5v14M5 12h14",
  dice: "M5 5h14v14H5zM9 9h.01M15 9h.01M12 12h.01M9 15h.01M15 15h.01",
};
const LINES = new Set(["fork", "share", "save", "help", "moon", "sun", "close", "plus", "dice"]);

export function Icon({ name }: { name: string }) {
  const isLine = LINES.has(name);
  return (
    <svg class="icon" viewBox="0 0 24 24" aria-hidden="true" fill={isLine ? "none" : "currentColor"} stroke={isLine ? "currentColor" : "none"}
      stroke-width="2" stroke-linecap="round" stroke-linejoin="round">
      <path d={PATHS[name]} />
    </svg>
  );
}

export function IconButton(props: { icon: string; label: string; onClick: () => void; disabled?: boolean; class?: string; id?: string; text?: string }) {
  return (
    <button type="button" id={props.id} class={`tool ${props.class ?? ""}`} title={props.label} aria-label={props.label} disabled={props.disabled} onClick={props.onClick}>
      <Icon name={props.icon} />
      {props.text && <span>{props.text}</span>}
    </button>
  );
}
