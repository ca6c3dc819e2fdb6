/**
 * A client for programs that take a seat on a running Moving Out Live server: states in, chunks of actions out.
 *
 *     const client = await Client.connect("http://127.0.0.1:8000", room);
 *     for await (const state of client.states()) client.act([[1, Math.cos(0), Math.sin(0), 0]]);
 */
export type Pose = {
    x: number;
    y: number;
    angle: number;
};
export type Ping = {
    tick: number;
    seat: number;
    item: number;
    x: number;
    y: number;
};
export type State = {
    tick: number;
    robots: Pose[];
    items: Pose[];
    held: number[];
    pings: Ping[];
};
export type Row = [distance: number, cos: number, sin: number, grasp: number];
export type Result = {
    outcome: string;
    ticks: number;
    metrics: Record<string, number>;
    recording: string;
};
export type Options = {
    name?: string;
    token?: string;
    WebSocket?: typeof globalThis.WebSocket;
};
/** The server refuses, or has closed the connection; the message is the server's. */
export declare class RemoteError extends Error {
    name: string;
}
/** One seat in one room, for a series of rounds. */
export declare class Client {
    #private;
    /** 0 blue, 1 red. @type {number} */ seat: number;
    /** Of this seat: with it a later connection comes back. @type {string} */ token: string;
    /** The map of the coming or running round, as JSON (docs/maps.md). @type {any} */ map: any;
    /** Of the last round. @type {Result | null} */ result: Result | null;
    /** @param {WebSocket} socket use `Client.connect` */
    constructor(socket: WebSocket);
    /**
     * Take an open seat for a program.
     * @param {string} server address, http(s) or ws(s)
     * @param {string} room
     * @param {Options} [options] `token`: of an earlier connection; `WebSocket`: where there is none (Node before 22)
     * @returns {Promise<Client>}
     */
    static connect(server: string, room: string, { name, token, WebSocket }?: Options): Promise<Client>;
    /**
     * Say ready, and give the newest state, ten a second, until the round ends; `result` tells how. Throws a RemoteError
     * when the server refuses or closes the connection, or the series ends without a result.
     * @returns {AsyncGenerator<State>}
     */
    states(): AsyncGenerator<State>;
    /** Whether the series has no further round. */
    get over(): boolean;
    /**
     * Play rows from now on, one per tick; they replace the rest of the last chunk. A press that was sent is not taken back.
     * @param {Row[]} rows
     */
    act(rows: Row[]): void;
    close(): void;
}
export type Frame = {
    format: string;
    names: string[];
};
