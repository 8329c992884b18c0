import { defineConfig } from "vite";

// One script, one style sheet, one page, under names that do not change: the program serves them from memory, each with a tag of its content.
export default defineConfig({
  base: "/",
  build: {
    target: "es2022",
    modulePreload: false,
    assetsInlineLimit: 0,
    rollupOptions: {
      output: { entryFileNames: "app.js", assetFileNames: "app[extname]", inlineDynamicImports: true },
    },
  },
});
