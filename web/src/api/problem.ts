interface Circumstances {
  status: number;
  code: string;
  pointer?: string | undefined;
  /** Seconds after which the service asks to be tried again. */
  retryAfter?: number | undefined;
}

/** An error of the service (RFC 9457), or of the way to it, in words that a shopper can read. */
export class Problem extends Error {
  override readonly name = "Problem";

  constructor(
    readonly title: string,
    readonly detail: string,
    readonly circumstances: Circumstances,
  ) {
    super(detail ? `${title}: ${detail}` : title);
  }

  get code(): string {
    return this.circumstances.code;
  }

  get retryAfter(): number | undefined {
    return this.circumstances.retryAfter;
  }

  /** The last part of the JSON pointer: the name of the field that is wrong. */
  get field(): string | undefined {
    const last = this.circumstances.pointer?.split("/").at(-1);
    return last ? last.replaceAll("~1", "/").replaceAll("~0", "~") : undefined;
  }

  static offline(): Problem {
    return new Problem("The service cannot be reached", "Check the connection, then try again.", {
      status: 0,
      code: "unreachable",
    });
  }

  static from(error: unknown): Problem {
    if (error instanceof Problem) return error;
    const detail = error instanceof Error ? error.message : String(error);
    return new Problem("Something went wrong", detail, { status: 0, code: "client" });
  }
}

interface ProblemDocument {
  title?: string;
  detail?: string;
  code?: string;
  pointer?: string;
}

/** Reads a failed answer; an answer that is not a problem document still gives a title. */
export function problemFrom(status: number, text: string, retryAfter: string | null): Problem {
  const document = parseDocument(text);
  const seconds = retryAfter === null ? Number.NaN : Number(retryAfter);
  return new Problem(document.title ?? `The service answered ${status}`, document.detail ?? "", {
    status,
    code: document.code ?? "unknown",
    pointer: document.pointer,
    retryAfter: Number.isFinite(seconds) ? seconds : undefined,
  });
}

function parseDocument(text: string): ProblemDocument {
  try {
    const value: unknown = JSON.parse(text);
    return typeof value === "object" && value !== null ? (value as ProblemDocument) : {};
  } catch {
    return {};
  }
}

export function isAbort(error: unknown): boolean {
  return error instanceof DOMException && error.name === "AbortError";
}
