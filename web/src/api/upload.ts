import { Problem, problemFrom } from "./problem";

/**
 * Uploads a file and reads the answer. XMLHttpRequest, because fetch does not tell how much of a body has been sent.
 * `onProgress` gets the share sent, 0 to 1; the service starts to read at 1.
 */
export function upload<Answer>(
  url: string,
  file: File,
  metadata: object,
  onProgress: (share: number) => void,
): Promise<Answer> {
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
      if (request.status >= 200 && request.status < 300) resolve(JSON.parse(request.responseText) as Answer);
      else reject(problemFrom(request.status, request.responseText, request.getResponseHeader("Retry-After")));
    };
    request.open("POST", url);
    request.send(form);
  });
}
