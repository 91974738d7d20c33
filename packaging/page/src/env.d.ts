declare module "*.toml" {
  const texts: Record<string, string>;
  export default texts;
}
declare module "core:*" {
  const answer: import("./core").Answer;
  export default answer;
}
declare module "licences:" {
  const packed: string;
  export default packed;
}
