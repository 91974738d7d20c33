declare module "*.toml" {
  const texts: Record<string, string>;
  export default texts;
}
declare module "core:*" {
  const answer: import("./core").Answer;
  export default answer;
}
declare module "file:*" {
  const text: string;
  export default text;
}
