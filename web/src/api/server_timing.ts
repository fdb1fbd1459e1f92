/** One stage of the service's work on a request. */
export interface Stage {
  name: string;
  milliseconds: number;
}

/** Parses a `Server-Timing` header (W3C Server Timing §2); entries without a duration are left out. */
export function parseServerTiming(header: string | null): Stage[] {
  const stages: Stage[] = [];
  for (const entry of header?.split(",") ?? []) {
    const [name, ...parameters] = entry.split(";").map((part) => part.trim());
    const duration = parameters.find((parameter) => /^dur\s*=/i.test(parameter));
    const milliseconds = Number(duration?.split("=")[1]?.trim().replaceAll('"', ""));
    if (name && duration && Number.isFinite(milliseconds)) stages.push({ name, milliseconds });
  }
  return stages;
}
