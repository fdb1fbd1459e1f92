import { Problem, problemFrom } from "./problem";
import type { Outfit, OutfitMetadata } from "./types";

/**
 * Uploads a garment file. XMLHttpRequest, because fetch does not tell how much of a body has been sent.
 * `onProgress` gets the share sent, 0 to 1; the service starts to read at 1.
 */
export function uploadOutfit(
  url: string,
  file: File,
  metadata: OutfitMetadata,
  onProgress: (share: number) => void,
): Promise<Outfit> {
  const form = new FormData();
  form.append("metadata", new Blob([JSON.stringify(metadata)], { type: "application/json" }));
  form.append("file", file, file.name);
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.upload.onprogress = (event) => {
      if (event.lengthComputable) onProgress(event.loaded / event.total);
    };
    request.onerror = () => reject(Problem.offline());
    request.onload = () => {
      if (request.status >= 200 && request.status < 300) resolve(JSON.parse(request.responseText) as Outfit);
      else reject(problemFrom(request.status, request.responseText, request.getResponseHeader("Retry-After")));
    };
    request.open("POST", url);
    request.send(form);
  });
}
