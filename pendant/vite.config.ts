import { defineConfig } from 'vite';

// No plugin: esbuild turns JSX into preact calls, and the page has no server-side part.
export default defineConfig({
  base: '/',
  esbuild: { jsx: 'automatic', jsxImportSource: 'preact' },
  // A test reads the language's reference page; by number, for a machine need not know the name localhost.
  server: { host: '127.0.0.1', fs: { allow: ['..'] } },
  build: {
    target: 'es2021',
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 900,
  },
});
