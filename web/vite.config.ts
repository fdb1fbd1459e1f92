import { defineConfig } from "vitest/config";

// `toile-viewer.js` keeps a stable name, so that a shop can load the element by URL.
export default defineConfig({
  base: "/",
  server: { proxy: { "/v1": "http://127.0.0.1:8080" } },
  build: {
    outDir: "dist",
    emptyOutDir: true,
    target: "es2022",
    chunkSizeWarningLimit: 900,
    rolldownOptions: {
      input: { page: "index.html", "toile-viewer": "src/viewer/index.ts" },
      preserveEntrySignatures: "exports-only",
      output: {
        entryFileNames: (chunk) => (chunk.name === "toile-viewer" ? "toile-viewer.js" : "assets/[name]-[hash].js"),
      },
    },
  },
  test: { environment: "happy-dom", include: ["tests/**/*.test.ts"] },
});
