// What the JavaScript of this project keeps; the format is prettier's (package.json), the types are tsc's (web/jsconfig.json).
import js from "@eslint/js";
import globals from "globals";

export default [
  { ignores: ["node_modules/", "build/", ".venv/", "web/messages.js"] },
  js.configs.recommended,
  {
    languageOptions: { globals: globals.browser },
    linterOptions: { reportUnusedDisableDirectives: "error" },
    rules: {
      eqeqeq: "error",
      "no-var": "error",
      "prefer-const": "error",
      "no-console": "error",
      "max-len": ["error", { code: 120, ignoreUrls: true }],
    },
  },
  { files: ["web/tests/**", "tests/**"], languageOptions: { globals: globals.node } },
];
